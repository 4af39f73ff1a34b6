"""Inextensible cables under Exudyn's own solvers: penalty masses, and constraint objects for implicit ones.

Their steps are those of `enforcement`: of RK44 near the stability limit, which falls with the square of the
element's length; of velocity Verlet smaller, since the forces depend on velocities.
"""

from collections.abc import Sequence

from reference_models.conventional.settings import Explicit, Implicit
from reference_models.enforced import enforced_case
from reference_models.scenes import Scene
from reference_models.trajectory import Case

ELEMENTS: dict[str, Sequence[int]] = {
    "planar_pendulum": (4, 5, 7, 10),
    "spatial_pendulum": (4, 5, 7, 10),
    "vibrating_ring": (8, 10, 14, 20),
    "power_line": (8, 12, 16, 20),
}
MOST_PENALTIES = 3  # of these meshes: Exudyn factorises the whole mass matrix at every stage
EXPLICIT_STEPS = {  # [s], at ten elements
    "planar_pendulum": (6.25e-4, 1e-4),
    "spatial_pendulum": (5e-4, 1e-4),
    "vibrating_ring": (8e-4, 1e-4),
    "power_line": (2e-3, 2e-4),
}
IMPLICIT_STEPS = (4e-3, 2e-3, 1e-3)


def enforced_cases(scene: Scene, quick: bool) -> list[Case]:
    """All of them for a scene."""
    counts = ELEMENTS[scene.name][:1] if quick else ELEMENTS[scene.name]
    steps = IMPLICIT_STEPS[:1] if quick else IMPLICIT_STEPS
    cases = [case for n in counts[:MOST_PENALTIES] for case in _penalty_cases(scene, n, quick)]
    return cases + [
        enforced_case(scene, n, "algebraic", Implicit(h, "modified", "sparse", 1e-6, 0.8))
        for n in counts
        for h in steps
    ]


def _penalty_cases(scene: Scene, elements: int, quick: bool) -> list[Case]:
    runge_kutta, verlet = (h * (10.0 / elements) ** 2 for h in EXPLICIT_STEPS[scene.name])
    cases = [enforced_case(scene, elements, "penaltyMass", Explicit(runge_kutta, "rungeKutta44"))]
    if not quick and elements <= ELEMENTS[scene.name][1]:
        cases.append(enforced_case(scene, elements, "penaltyMass", Explicit(verlet)))
    return cases
