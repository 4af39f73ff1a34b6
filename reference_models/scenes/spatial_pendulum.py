"""Spatial flexible pendulum, section 4.3 of the paper: pushed sideways, a pinned cable falls.

The cable of the planar pendulum. The hinge leaves all rotations free; the initial velocity is
across the cable and horizontal, and grows linearly from the hinge to the tip. The axes are those of
the paper and of the reference: x along the cable, y with the initial velocity, gravity along -z.
"""

from .planar_pendulum import SCENE as PLANAR
from .scene import Pin, Reference, Scene

SCENE = Scene(
    name="spatial_pendulum",
    cable=PLANAR.cable,
    supports=(Pin(at=0.0),),
    gravity=(0.0, 0.0, -9.81),
    end_time=5.0,
    observe={"tip": 1.0},
    end_velocity=(0.0, 3.0, 0.0),
    reference=Reference(
        file="spatial_pendulum_limit.csv",
        axes=("x", "y", "z"),
        uncertainty=1e-4,
        source="MBDyn 1.7.3, estimate of the inextensible, unshearable limit",
    ),
)
