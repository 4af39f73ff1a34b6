"""Bending treated implicitly by an explicit scheme: a constant matrix beside the mass.

A central difference scheme for M q_tt + D q_t + K q = F takes

    (M + theta h^2 K + h/2 D) a_n = F - K q_n - D v_(n-1/2),    a_n = (q_(n+1) - 2 q_n + q_(n-1)) / h^2,

the matrix on the left constant: D acts at the velocity (q_(n+1) - q_(n-1)) / (2 h). theta >= 1/4
takes bending out of the step limit, h/2 D the bending damping.
"""

from dataclasses import dataclass

from .cable import Section


@dataclass(frozen=True)
class ImplicitBending:
    """What of the bending forces is in the matrix on the left.

    stiffness: theta h^2 [s^2].   damping: h/2 [s]; 0: the damping is explicit.
    step: h of axial stiffness, see `axial` [s]; 0: it is explicit.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    step: float = 0.0

    def factor(self, section: Section) -> float:
        """Of the curvature's Gram matrix beside the mass: theta h^2 EI + h/2 D [N m^2 s^2].

        The damping of cables that stretch has a matrix of its own, see `axial_damping`.
        """
        damping = self.damping * section.bending_damping if section.axial_stiffness is None else 0.0
        return self.stiffness * section.bending_stiffness + damping


EXPLICIT = ImplicitBending()
