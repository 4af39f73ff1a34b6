"""Scenes that the adviser was not tuned on."""

import math
from dataclasses import replace

from reference_models.scenes import Scene, load_scene
from reference_models.scenes.load import PointForce, Sine
from reference_models.scenes.scene import Cable
from reference_models.scenes.section import Round, Section
from reference_models.scenes.shape import Circle, Line, Parabolas
from reference_models.scenes.support import Clamp, Pin

_G = (0.0, -9.81, 0.0)
_WIRE = Round(radius=1e-3, density=7850.0, youngs_modulus=2.0e11)
_ROPE = Section(mass_per_length=0.15, bending_stiffness=0.02, axial_stiffness=4e5)
_RUBBER = Section(mass_per_length=0.08, bending_stiffness=0.02, axial_stiffness=50.0)


def _hanging(name: str, section: Round | Section, length: float, end_time: float) -> Scene:
    """Pinned, released when horizontal."""
    return Scene(
        name=name,
        cable=Cable(length, section),
        supports=(Pin(at=0.0),),
        gravity=_G,
        end_time=end_time,
        observe={"tip": 1.0},
    )


def _ring() -> Scene:
    circle = Circle(radius=0.3)
    drive = Sine(angular_frequency=6.0 * math.pi)
    return Scene(
        name="small ring, pulled",
        cable=Cable(circle.circumference, _WIRE, circle),
        supports=(),
        gravity=(0.0, 0.0, 0.0),
        end_time=1.0,
        observe={"N1": 0.0},
        loads=(
            PointForce(at=0.0, force=(3.0, 0.0, 0.0), history=drive),
            PointForce(at=0.5, force=(-3.0, 0.0, 0.0), history=drive),
        ),
    )


def _sagging() -> Scene:
    line = Parabolas(width=2.0, sag=0.3)
    return Scene(
        name="rope that drops a weight",
        cable=Cable(2.12, _ROPE, line, "straight"),
        supports=(Pin(at=0.0), Pin(at=1.0)),
        gravity=_G,
        end_time=2.0,
        observe={"middle": 0.5},
        start_loads=(PointForce(at=0.5, force=(0.0, -3.0, 0.0)),),
        starts_from_equilibrium=True,
    )


def validation_scenes() -> list[Scene]:
    """One of each kind; the last one is made of rubber."""
    wire = _hanging("steel wire", _WIRE, 1.0, 1.5)
    upright = (0.0, -1.0, 0.0)
    hanging = Cable(0.8, _WIRE, Line(direction=upright))
    return [
        wire,
        _hanging("soft rope", _ROPE, 0.6, 1.2),
        replace(_hanging("moon", _WIRE, 2.0, 5.0), gravity=(0.0, -1.62, 0.0)),
        replace(wire, name="kicked wire", cable=hanging, end_velocity=(3.0, 0.0, 0.0), end_time=1.5),
        replace(wire, name="wire kicked in space", cable=hanging, end_velocity=(2.0, 0.0, 2.5)),
        replace(wire, name="falling cantilever", cable=Cable(0.5, _WIRE), supports=(Clamp(at=0.0),)),
        replace(wire, name="thrown wire", supports=(), end_velocity=(0.0, 4.0, 0.0), end_time=1.0),
        _ring(),
        _sagging(),
        replace(load_scene("planar_pendulum"), name="two seconds of Table 1", end_time=2.0),
        _hanging("rubber band", _RUBBER, 1.0, 1.0),
    ]
