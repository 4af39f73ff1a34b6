"""Two-span power line after ice shedding, section 4.4 of the paper.

Ends A = (0, 0) and C = (2 W, 0) are pinned; the middle B hangs by a rigid rod of 0.1 m. The line
rests under gravity and the weight of the ice at P1, a quarter along the line; at t = 0 the ice is
gone. P1 and P2 are the paper's Fig. 13, the direction at C its Fig. 14. The parabola of Eq. (40) is
only where the static solution begins: the line is straight when free of stress. It is 2.4e-4 m a
span shorter than the line, since Eq. (40) keeps the leading term of its arc length only. No reference
trajectory exists: refined solutions are compared with each other.

The paper is not consistent: it speaks of a radius of about 2 mm, but a round section with its EI and
EA has 2 sqrt(EI / EA) = 2.38 mm; and Eq. (37) with its C = 0.85 and 20 elements gives
h = 9.01e-4 s where it prints 9.35e-4 s. The values of EI, EA and rho_A are taken as printed.
"""

import math

from .load import PointForce
from .scene import Cable, Scene
from .section import Section
from .shape import Parabolas
from .support import Hanger, Pin

_WIDTH = 3.322  # W [m]
_LENGTH = 6.7036  # L [m]
_SAG = math.sqrt(3.0 * (_LENGTH - 2.0 * _WIDTH) * _WIDTH / 16.0)  # d_m [m], Eq. (40)
_ROD = 0.1  # l [m]
_ICE = 1.162  # F_ice [N]

SCENE = Scene(
    name="power_line",
    cable=Cable(
        length=_LENGTH,
        section=Section(mass_per_length=9.26e-2, bending_stiffness=2.1113, axial_stiffness=1490955.0),
        shape=Parabolas(width=_WIDTH, sag=_SAG, spans=2),
        stress_free="straight",
    ),
    supports=(Pin(at=0.0), Hanger(at=0.5, length=_ROD, anchor=(_WIDTH, _ROD, 0.0)), Pin(at=1.0)),
    gravity=(0.0, -9.81, 0.0),
    end_time=5.0,
    observe={"P1": 0.25, "P2": 0.75},
    start_loads=(PointForce(at=0.25, force=(0.0, -_ICE, 0.0)),),
    starts_from_equilibrium=True,
)
