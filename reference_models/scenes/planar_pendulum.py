"""Planar flexible pendulum, section 4.2 of the paper: a pinned cable falls from the horizontal.

The paper and the reference move in x-z with gravity along -z; here it is x-y and -y. The only
place that converts is `axes` below.
"""

from .scene import Cable, Pin, Reference, Round, Scene

SCENE = Scene(
    name="planar_pendulum",
    cable=Cable(length=1.8, section=Round(radius=2e-3, density=2766.76, youngs_modulus=6.895e9)),
    supports=(Pin(at=0.0),),
    gravity=(0.0, -9.81, 0.0),
    end_time=5.0,
    observe={"tip": 1.0},
    reference=Reference(
        file="planar_pendulum_limit.csv",
        axes=("x", "z", "-y"),
        uncertainty=5e-5,
        source="MBDyn 1.7.3, estimate of the inextensible, unshearable limit",
    ),
)
