"""Conventional cables: the tuned rows of the tables, and series over meshes, steps and quadratures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from reference_models.conventional.cases import native_case
from reference_models.conventional.model import Quadrature
from reference_models.conventional.settings import Explicit, ExplicitIntegrator, Implicit
from reference_models.conventional.stability import largest_stable_step
from reference_models.conventional.zhai import largest_zhai_step, zhai_case
from reference_models.scenes import Scene
from studies import ring, table1, table2, table3

from .selection import Selection

TABLES: dict[str, Any] = {
    "planar_pendulum": table1,
    "spatial_pendulum": table2,
    "vibrating_ring": ring,
    "power_line": table3,
}
FRACTIONS = (1.0, 0.5)  # of the largest stable step
ZHAI_FRACTIONS = (0.95, 0.5)

ExplicitRow = tuple[ExplicitIntegrator, int, Quadrature]
CoarseRow = tuple[int, float, float, float]


@dataclass(frozen=True)
class Series:
    """What is run beside the tuned rows.

    full, lobatto: numbers of elements with each quadrature, under both implicit integrators.
    steps: of them [s].   explicit: at their largest stable steps.   zhai: elements and quadrature.
    coarse: cheap rather than accurate: elements (Lobatto), step [s], Newton's tolerance, spectral radius.
    The first row of `explicit` and of `zhai` also runs at half its step.
    """

    full: Sequence[int]
    lobatto: Sequence[int]
    steps: Sequence[float]
    explicit: Sequence[ExplicitRow] = ()
    zhai: Sequence[tuple[int, Quadrature]] = ()
    coarse: Sequence[CoarseRow] = ()


_VERLET: ExplicitIntegrator = "velocityVerlet"
_RK: ExplicitIntegrator = "rungeKutta44"
_PENDULUM = Series(
    full=(6, 10, 14, 20),
    lobatto=(3, 4, 6, 8, 10),
    steps=(5e-3, 3.5e-3, 2e-3),
    explicit=((_VERLET, 3, "lobatto"), (_RK, 4, "lobatto"), (_VERLET, 6, "full"), (_VERLET, 8, "lobatto")),
    zhai=((4, "lobatto"), (6, "full")),
    coarse=(
        (2, 6e-3, 1e-3, 0.7),
        (2, 7e-3, 1e-4, 0.6),
        (2, 8e-3, 1e-4, 0.6),
        (2, 8e-3, 1e-4, 0.8),
        (3, 6e-3, 1e-4, 0.6),
        (3, 7e-3, 1e-4, 0.6),
        (3, 8e-3, 1e-4, 0.6),
        (3, 1e-2, 1e-4, 0.6),
    ),
)
SERIES = {
    "planar_pendulum": _PENDULUM,
    "spatial_pendulum": _PENDULUM,
    "vibrating_ring": Series(
        full=(20, 28, 40),
        lobatto=(8, 10, 14, 20),
        steps=(8e-3, 4e-3, 2e-3),
        explicit=((_VERLET, 10, "lobatto"), (_RK, 10, "lobatto"), (_VERLET, 20, "full")),
        zhai=((10, "lobatto"),),
        coarse=((8, 6e-3, 1e-3, 0.7), (8, 8e-3, 1e-4, 0.8), (8, 8e-3, 1e-3, 0.7), (8, 1e-2, 1e-3, 0.7)),
    ),
    "power_line": Series(
        full=(20, 32, 40),
        lobatto=(8, 12, 20),
        steps=(7.5e-3, 5e-3, 2.5e-3),
        explicit=((_VERLET, 8, "lobatto"), (_RK, 8, "lobatto")),
        zhai=((8, "lobatto"), (16, "full")),
        coarse=((4, 1.25e-2, 1e-3, 0.7), (4, 2e-2, 1e-4, 0.6), (8, 1.25e-2, 1e-3, 0.7), (8, 2e-2, 1e-4, 0.6)),
    ),
}
QUICK = {
    "planar_pendulum": Series((10,), (4,), (5e-3,), ((_VERLET, 3, "lobatto"),), ((3, "lobatto"),)),
    "spatial_pendulum": Series((10,), (4,), (5e-3,), ((_RK, 3, "lobatto"),)),
    "vibrating_ring": Series((), (10,), (5e-3,)),
    "power_line": Series((), (8,), (5e-3,)),
}
TRAPEZOIDAL_STEPS = (2.5e-3, 1.25e-3)  # [s]; larger ones diverge from the solution


def native_selection(scene: Scene, quick: bool) -> Selection:
    """All of them for a scene; explicit ones first search for their largest stable steps."""
    selection, series = Selection(), QUICK[scene.name] if quick else SERIES[scene.name]
    if not quick:
        selection.add(*TABLES[scene.name].implicit_cases(scene))
    _add_implicit(selection, scene, series, quick)
    if not quick:
        selection.add(*TABLES[scene.name].explicit_cases(scene))
    _add_explicit(selection, scene, series)
    return selection


def _add_implicit(selection: Selection, scene: Scene, series: Series, quick: bool) -> None:
    meshes: list[tuple[Quadrature, int]] = [("full", n) for n in series.full]
    meshes += [("lobatto", n) for n in series.lobatto]
    for quadrature, elements in meshes:
        linear = "sparse" if elements > 6 else "dense"
        for h in series.steps:
            solver = Implicit(h, "modified", linear, 1e-4)
            selection.add(native_case(scene, elements, solver, quadrature))
        for h in TRAPEZOIDAL_STEPS[: 1 if quick else None]:
            solver = Implicit(h, "modified", linear, 1e-4, integrator="trapezoidal")
            selection.add(native_case(scene, elements, solver, quadrature))
    for elements, h, tolerance, radius in series.coarse:
        solver = Implicit(h, "modifiedEachStep", "dense", tolerance, radius)
        selection.add(native_case(scene, elements, solver, "lobatto"))


def _add_explicit(selection: Selection, scene: Scene, series: Series) -> None:
    for place, (integrator, elements, quadrature) in enumerate(series.explicit):
        largest = largest_stable_step(scene, elements, integrator, quadrature)
        for fraction in FRACTIONS[: 1 if place else 2]:
            selection.add(native_case(scene, elements, Explicit(fraction * largest, integrator), quadrature))
    for place, (elements, quadrature) in enumerate(series.zhai):
        largest = largest_zhai_step(scene, elements, quadrature)
        for fraction in ZHAI_FRACTIONS[: 1 if place else 2]:
            selection.add(zhai_case(scene, elements, fraction * largest, quadrature=quadrature))
