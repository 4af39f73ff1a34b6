"""How long a step may be that resolves the motion of a cable.

A transverse wave of the speed c, which the tension gives it, takes 20 steps to pass an element: the error in
time is then near that of the mesh. c^2 is the tension over rho_A that weight, loads and inertia can cause at
most, and twice the energy by mass that the motion starts with, as the node sees it where nothing can be hit
that is the slowest one in the `Flight` of all; among bodies, that of bending is left out where the cable
rests in an equilibrium. The first vibration of the bent cable is resolved in any case, and among bodies all
bending waves that the mesh resolves, or of cables that are lighter than each body, longer ones. Of elements
whose lengths differ, a wave needs as many of its size as it spans: single short ones among others resolve
nothing that the others do not, nor do short cables in a row with others. How fast the motion really is, the
watch finds out, see `watch`: then the step becomes shorter, down to one whose error in bending waves is that
of the mesh, and where cables stretch, one in which axial waves pass a share of an element.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..arrays import Array
from ..cable.assembly import elastic_energy
from ..cable.cable import Cable
from ..system import ELASTIC, REPORTED, report_energy
from .cable_run import CableRun
from .coupled_run import Run
from .rows_of_cables import Row
from .watch import SMALL

STEPS_BY_ELEMENT = 20.0  # while a wave passes it
STEPS_BY_AXIAL_WAVE = 4.0  # while it passes an element: more resolve what the mesh does not
SHORT_WAVE = 0.2  # step times the frequency of a bending wave of 2 pi elements, among bodies
SPANNED = 6  # elements by such a wave
AT_REST = 1e-6  # share of the energy of bending that may be released at the start of a cable at rest
BY_DRAG = 0.02  # step times the rate at which drag slows a cable down
FIRST_VIBRATION = 0.085  # step over L^2 sqrt(rho_A / EI): 0.3 / 3.52, h w of a cantilever's first one


def accurate_step(
    run: CableRun,
    row: Row,
    time: float,
    flight: Array,
    acceleration: Callable[[], float] | None,
    may_touch: Callable[[], bool] | None = None,
) -> float:
    """Largest step that resolves the motion of a cable in time as well as its mesh does in space [s].

    row: that the cable is part of.
    flight: (n_dof,) velocities of a frame that flies along with all that moves, see `Flight`.
    acceleration: among bodies, the largest one of nodes at the start [m/s^2], asked where it matters.
    may_touch: whether there is anything that the cable may hit; None: there is not.
    """
    with np.errstate(over="ignore"):
        speed = _wave_speed(run, time, flight, acceleration, may_touch)
    of_waves = _resolved(row.lengths, row.own) / (STEPS_BY_ELEMENT * speed) if speed > 0.0 else math.inf
    bends = float(np.sqrt(row.times).sum()) ** 2
    of_drag = BY_DRAG / run.drag_rate if run.drag_rate > 0.0 else math.inf
    return min(of_waves, FIRST_VIBRATION * bends, of_drag)


def step_of_short_waves(run: CableRun, row: Row, lightest: float) -> float:
    """Largest step that resolves the bending waves that the mesh of a cable resolves [s].

    Among bodies, joints and torques make such waves, of a size that nobody knows before the run. Their energy
    is at most some share of that of the motion which a light cable has of its mass: then waves count whose
    frequency is lower by the square root of that share.

    row: that the cable is part of.   lightest: body [kg].
    """
    cable = run.scene_cable.cable
    longer = max(1.0, math.sqrt(lightest / (cable.section.mass_per_length * cable.length)))
    return longer * SHORT_WAVE * _resolved(row.times, row.own)


def step_of_shortest_element(row: Row) -> float:
    """As `step_of_short_waves`, if all elements were as short as the shortest one [s]."""
    return SHORT_WAVE * float(row.times.min())


def resolution_of_mesh(run: Run, time: float, theta: float) -> Array:
    """(4,) by which the errors of step and mesh in waves of a cable are known, see `watch`.

    c^2 [m^2/s^2], s^2 = EI / rho_A [m^4/s^2], the length l of elements [m], and theta [-].
    Cables that stretch have other waves, too, and bodies: of these, only the shortest step that serves
    stretch, squared [s^2], or 0, and theta.
    """
    stretching = [cable for cable in run.cables if cable.stretches]
    if stretching or not isinstance(run, CableRun):
        shortest = min(map(step_of_axial_waves, stretching), default=0.0)
        return np.array([shortest**2, 0.0, 0.0, theta])
    cable = run.scene_cable.cable
    section = cable.section
    stiffness = section.bending_stiffness / section.mass_per_length
    lengths = cable.element_lengths
    with np.errstate(over="ignore"):
        squared = _wave_speed(run, time, run.flight) ** 2
        return np.array([squared, stiffness, _resolved(lengths, slice(0, len(lengths))), theta])


def small_error(run: Run) -> float:
    """x . M x / 2 of errors x that no step is shortened for [kg m^2]; of parts, see `Motions`."""
    if not isinstance(run, CableRun):
        return 0.0
    cable = run.scene_cable.cable
    return 0.5 * SMALL**2 * cable.section.mass_per_length * cable.length**3


def step_of_axial_waves(cable: Cable) -> float:
    """The shortest step that serves stretch: with it, forces of axial vibrations are right [s]."""
    section, length = cable.section, float(cable.element_lengths.min())
    assert section.axial_stiffness
    passing = length * math.sqrt(section.mass_per_length / section.axial_stiffness)
    return passing / STEPS_BY_AXIAL_WAVE


def _resolved(sizes: Array, own: slice) -> float:
    """Of the elements that resolve the shortest waves, the largest one that these span.

    sizes: (m,) of elements in a row.   own: place of a cable's, which the waves reach.
    """
    reached = sizes[max(own.start - SPANNED + 1, 0) : own.stop + SPANNED - 1]
    return float(sliding_window_view(reached, min(SPANNED, reached.size)).max(axis=1).min())


def _wave_speed(
    run: CableRun,
    time: float,
    flight: Array,
    acceleration: Callable[[], float] | None = None,
    may_touch: Callable[[], bool] | None = None,
) -> float:
    """c [m/s], see above.   flight, acceleration, may_touch: see `accurate_step`."""
    cable = run.scene_cable.cable
    shape = cable.reference.shape
    inputs = run.loads.at(time)
    forces = np.linalg.norm(inputs[: run.state.q.size].reshape(shape)[:, 0], axis=1)
    density, v = cable.section.mass_per_length, (run.state.v - flight).reshape(shape)[:, 0]
    slowest = v[np.argmin((v * v).sum(axis=1))]  # to fly along pulls nothing, until something is hit
    if may_touch is not None and slowest.any() and may_touch():
        slowest = np.zeros_like(slowest)
    fastest = float(((v - slowest) ** 2).sum(axis=1).max())
    squared = float(forces.sum()) / density + fastest
    squared += _of_motions(inputs[run.state.q.size :], cable, slowest)
    of_bending = 2.0 * max(0.0, _bending_energy(run, inputs)) / (density * cable.length)
    if acceleration is not None and of_bending > squared:
        is_at_rest = fastest + 2.0 * acceleration() * cable.length <= AT_REST * of_bending
        of_bending = 0.0 if is_at_rest else of_bending
    return math.sqrt(squared + of_bending)


def _bending_energy(run: CableRun, inputs: Array) -> float:
    """[J]; by `report_energy`, which each run compiles, where that counts nothing else."""
    state, cable = run.state, run.scene_cable.cable
    if cable.stretches:
        return float(elastic_energy(run.system.chain, state.q.reshape(cable.reference.shape)))
    energy_report, force = np.zeros(REPORTED), np.zeros(state.q.size)
    report_energy(run.called, inputs, state.q, state.v, np.zeros(force.size), force, energy_report)
    return float(energy_report[ELASTIC])


def _of_motions(inputs: Array, cable: Any, slowest: Array) -> float:
    """Speeds squared of supports that move, and what their accelerations may do to the tension [m^2/s^2].

    slowest: (dim,) velocity of a node that sees them, each along its own way [m/s].
    """
    _, velocities, accelerations = inputs.reshape(-1, 3, cable.dimension).transpose(1, 0, 2)
    speeds = np.linalg.norm(velocities, axis=1)
    seen = speeds - velocities @ slowest / np.where(speeds > 0.0, speeds, 1.0)
    return float((seen**2 + np.linalg.norm(accelerations, axis=1) * cable.length).sum())
