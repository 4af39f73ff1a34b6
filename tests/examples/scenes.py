"""The examples of the paper's four scenes: their motions, and the data they should have."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from examples.animation import motion
from reference_models.data import reference_trajectory
from reference_models.model import silence
from reference_models.scenes import load_scene


def run(example):
    """Times (n,) [s] and nodal positions (n, k, 3) [m] of an example, run as it is."""
    with silence():
        return motion(example)


def require_section(example_section, scene):
    """The numbers in a script are those of the scene, to the digits that are printed."""
    section = load_scene(scene).cable.section
    assert example_section.massPerLength == pytest.approx(section.mass_per_length, rel=3e-6)
    assert example_section.bendingStiffness == pytest.approx(section.bending_stiffness, rel=1e-6)


def distance_to_reference(scene, times, positions):
    """Largest distance of a point to the independent reference trajectory [m]."""
    reference = reference_trajectory(load_scene(scene))
    exact = CubicSpline(reference.times, reference.positions)(times)
    return np.linalg.norm(positions - exact, axis=1).max()


def largest_stretch(points, length):
    """How much longer than their arc length the chords between nodes are at most; 1 + small, or less."""
    chords = np.linalg.norm(np.diff(points, axis=1), axis=2)
    return (chords / length).max()
