"""What is run on each scene: every formulation, integrator, mesh and step, below its stability limit.

Tuned rows are those of the tables. Inextensible runs are not ended for their energy: it is their errors that
are measured. Penalty masses and algebraic constraints have the steps of `enforcement`: of RK44 near the
stability limit, which falls with the square of the element's length; of velocity Verlet smaller, since the
forces depend on velocities.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice, product

from exudyn_inext import ExplicitSettings, Zhai
from reference_models.conventional.cases import native_case
from reference_models.conventional.model import Quadrature
from reference_models.conventional.settings import Explicit, ExplicitIntegrator, Implicit
from reference_models.conventional.stability import largest_stable_step
from reference_models.conventional.zhai import largest_zhai_step, zhai_case
from reference_models.enforced import enforced_case
from reference_models.inextensible import Inextensible, has_corrector
from reference_models.peers import rigid_links
from reference_models.peers.rigid_links import RigidLinks
from reference_models.scenes import Scene
from reference_models.trajectory import Case
from studies import ring, table1, table2, table3
from studies.harness.cases import case_at_limit, explicit_case, kept_case, unguarded

TABLES = {table.scene: table for table in (table1.TABLE, table2.TABLE, ring.TABLE, table3.TABLE)}
QUICK = 4  # cases of each kind that a quick run has


def cases_of(scene: Scene, quick: bool) -> list[Case]:
    """All of them, or the first ones of each kind; of equal labels the first, as tuned rows meet series."""
    makers = (inextensible_cases, enforced_cases, native_cases, links_cases)
    return unique(chain.from_iterable(islice(make(scene), QUICK if quick else None) for make in makers))


def unique(cases: Iterable[Case]) -> list[Case]:
    """In their order; of equal labels, the first."""
    found: dict[str, Case] = {}
    for case in cases:
        found.setdefault(case.label, case)
    return list(found.values())


_VERLET: ExplicitIntegrator = "velocityVerlet"
_RK: ExplicitIntegrator = "rungeKutta44"


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is run on a scene beside the tuned rows.

    limited: elements of inextensible runs at the stability limits.   zeta: of Zhai [1/s].
    scaled, steps: elements and steps [s] with scaled mass.
    coarse: elements and steps [s] of such rows that are cheap rather than accurate.
    enforced: elements under native solvers.   at_ten: steps of RK44, velocity Verlet [s] at ten elements.
    full, lobatto, native_steps: native elements with each quadrature, steps [s]; both implicit integrators.
    explicit, zhai: native, at their largest stable steps; the first row of each also at half its step.
    native_coarse: cheap: elements (Lobatto), step [s], Newton's tolerance, spectral radius.
    """

    limited: Sequence[int]
    scaled: Sequence[int]
    steps: Sequence[float]
    coarse: Sequence[tuple[int, float]]
    enforced: Sequence[int]
    at_ten: tuple[float, float]
    full: Sequence[int]
    lobatto: Sequence[int]
    native_steps: Sequence[float]
    zeta: float = 100.0
    explicit: Sequence[tuple[ExplicitIntegrator, int, Quadrature]] = ()
    zhai: Sequence[tuple[int, Quadrature]] = ()
    native_coarse: Sequence[tuple[int, float, float, float]] = ()


_PENDULUM = Plan(
    limited=(3, 4, 5, 6, 8, 10, 14, 20),
    scaled=(3, 4, 5, 6, 8, 10, 14, 20, 28),
    steps=(5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
    coarse=((2, 1e-2), (2, 5e-3), (3, 1e-2), (4, 1e-2), (5, 1e-2), (4, 3.34e-3), (5, 3.34e-3), (6, 3.34e-3)),
    enforced=(4, 5, 7, 10),
    at_ten=(6.25e-4, 1e-4),
    full=(6, 10, 14, 20),
    lobatto=(3, 4, 6, 8, 10),
    native_steps=(5e-3, 3.5e-3, 2e-3),
    explicit=((_VERLET, 3, "lobatto"), (_RK, 4, "lobatto"), (_VERLET, 6, "full"), (_VERLET, 8, "lobatto")),
    zhai=((4, "lobatto"), (6, "full")),
    native_coarse=(
        (2, 6e-3, 1e-3, 0.7), (2, 7e-3, 1e-4, 0.6), (2, 8e-3, 1e-4, 0.6), (2, 8e-3, 1e-4, 0.8),
        (3, 6e-3, 1e-4, 0.6), (3, 7e-3, 1e-4, 0.6), (3, 8e-3, 1e-4, 0.6), (3, 1e-2, 1e-4, 0.6),
    ),
)  # fmt: skip
PLANS = {
    "planar_pendulum": _PENDULUM,
    "spatial_pendulum": replace(_PENDULUM, zeta=150.0, at_ten=(5e-4, 1e-4)),
    "vibrating_ring": Plan(
        limited=(6, 8, 10, 12, 16, 20, 28),
        scaled=(8, 10, 12, 14, 16, 20, 28, 40),
        steps=(2e-3, 1e-3, 5e-4, 2.5e-4),
        coarse=((6, 5e-3), (6, 3.34e-3), (8, 3.34e-3), (8, 5e-3), (10, 3.34e-3)),
        zeta=300.0,
        enforced=(8, 10, 14, 20),
        at_ten=(8e-4, 1e-4),
        full=(20, 28, 40),
        lobatto=(8, 10, 14, 20),
        native_steps=(8e-3, 4e-3, 2e-3),
        explicit=((_VERLET, 10, "lobatto"), (_RK, 10, "lobatto"), (_VERLET, 20, "full")),
        zhai=((10, "lobatto"),),
        native_coarse=(
            (8, 6e-3, 1e-3, 0.7), (8, 8e-3, 1e-4, 0.8), (8, 8e-3, 1e-3, 0.7), (8, 1e-2, 1e-3, 0.7),
        ),
    ),
    "power_line": Plan(
        limited=(4, 8, 12, 16, 20, 28, 40),
        scaled=(8, 12, 16, 20, 28, 40, 60),
        steps=(5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
        coarse=((4, 1e-2), (4, 5e-3), (8, 1e-2), (12, 1e-2), (16, 1e-2)),
        zeta=300.0,
        enforced=(8, 12, 16, 20),
        at_ten=(2e-3, 2e-4),
        full=(20, 32, 40),
        lobatto=(8, 12, 20),
        native_steps=(7.5e-3, 5e-3, 2.5e-3),
        explicit=((_VERLET, 8, "lobatto"), (_RK, 8, "lobatto")),
        zhai=((8, "lobatto"), (16, "full")),
        native_coarse=(
            (4, 1.25e-2, 1e-3, 0.7), (4, 2e-2, 1e-4, 0.6), (8, 1.25e-2, 1e-3, 0.7), (8, 2e-2, 1e-4, 0.6),
        ),
    ),
}  # fmt: skip


FRACTIONS = (0.95, 0.5)  # of the stability limit
SCHEMES: dict[str, str | Zhai] = {
    "Zhai": "Zhai",
    "Zhai with corrector": Zhai(0.0, 0.0, corrector=True),
    "RK4": "RK4",
    "RATTLE": "RATTLE",
}
EXTRA_THETA, COARSE = 0.3, 2.5e-3  # RATTLE takes this theta, too, from this step on [s]
SCALED = (("Zhai", 0.3), ("RATTLE", 0.25), ("RATTLE", EXTRA_THETA))
DECAY = 0.6  # most of h zeta; Zhai's limit is 1


def inextensible_cases(scene: Scene) -> Iterator[Case]:
    """Every scheme at fractions of its limit on many meshes, then with scaled mass."""
    plan = PLANS[scene.name]
    yield from (explicit_case(scene, *row) for row in TABLES[scene.name].inextensible)
    for elements in plan.limited:
        for name in SCHEMES:
            yield from limited_cases(scene, elements, name)
    for elements, h in [*product(plan.scaled, plan.steps), *plan.coarse]:
        for integrator, theta in SCALED:
            if theta == EXTRA_THETA and integrator == "RATTLE" and h < COARSE:
                continue
            zeta = min(plan.zeta, DECAY / h) if integrator == "Zhai" else ExplicitSettings.stabilizationRate
            model = Inextensible(elements, unguarded(integrator, h, theta, zeta))
            yield _described(kept_case(scene, model), model)


def limited_cases(scene: Scene, elements: int, name: str) -> list[Case]:
    """At fractions of the stability limit."""
    model = Inextensible(elements, unguarded(SCHEMES[name], None))
    return [_described(case_at_limit(scene, model, part), model) for part in FRACTIONS]


def _described(case: Case, model: Inextensible) -> Case:
    """With what its method is told apart by."""
    own = {"massScaling": model.settings.massScaling, "corrector": has_corrector(model.settings)}
    return replace(case, details={**own, **case.details})


MOST_PENALTIES = 3  # of the meshes: Exudyn factorises the whole mass matrix at every stage
IMPLICIT_STEPS = (4e-3, 2e-3, 1e-3)


def enforced_cases(scene: Scene) -> Iterator[Case]:
    """Penalty masses for explicit solvers, algebraic constraints for implicit ones."""
    plan = PLANS[scene.name]
    for n in plan.enforced[:MOST_PENALTIES]:
        runge_kutta, verlet = (h * (10.0 / n) ** 2 for h in plan.at_ten)
        yield enforced_case(scene, n, "penaltyMass", Explicit(runge_kutta, "rungeKutta44"))
        if n <= plan.enforced[1]:
            yield enforced_case(scene, n, "penaltyMass", Explicit(verlet))
    for n, h in product(plan.enforced, IMPLICIT_STEPS):
        yield enforced_case(scene, n, "algebraic", Implicit(h, "modified", "sparse", 1e-6, 0.8))


EXPLICIT_FRACTIONS, ZHAI_FRACTIONS = (1.0, 0.5), (0.95, 0.5)  # of the largest stable step
TRAPEZOIDAL_STEPS = (2.5e-3, 1.25e-3)  # [s]; larger ones diverge from the solution


def native_cases(scene: Scene) -> Iterator[Case]:
    """Tuned rows and series; explicit ones first search for their largest stable steps."""
    table, plan = TABLES[scene.name], PLANS[scene.name]
    yield from (native_case(scene, *row) for row in table.implicit)
    yield from _implicit_series(scene, plan)
    yield from table.explicit_cases(scene)
    yield from _explicit_series(scene, plan)


def _implicit_series(scene: Scene, plan: Plan) -> Iterator[Case]:
    for quadrature, elements in [*product(["full"], plan.full), *product(["lobatto"], plan.lobatto)]:
        linear = "sparse" if elements > 6 else "dense"
        solvers = [Implicit(h, "modified", linear, 1e-4) for h in plan.native_steps]
        for h in TRAPEZOIDAL_STEPS:
            solvers.append(Implicit(h, "modified", linear, 1e-4, integrator="trapezoidal"))
        yield from (native_case(scene, elements, solver, quadrature) for solver in solvers)
    for elements, h, tolerance, radius in plan.native_coarse:
        solver = Implicit(h, "modifiedEachStep", "dense", tolerance, radius)
        yield native_case(scene, elements, solver, "lobatto")


def _explicit_series(scene: Scene, plan: Plan) -> Iterator[Case]:
    for place, (integrator, elements, quadrature) in enumerate(plan.explicit):
        largest = largest_stable_step(scene, elements, integrator, quadrature)
        for fraction in EXPLICIT_FRACTIONS[: 1 if place else 2]:
            yield native_case(scene, elements, Explicit(fraction * largest, integrator), quadrature)
    for place, (elements, quadrature) in enumerate(plan.zhai):
        largest = largest_zhai_step(scene, elements, quadrature)
        for fraction in ZHAI_FRACTIONS[: 1 if place else 2]:
            yield zhai_case(scene, elements, fraction * largest, quadrature=quadrature)


LINKED_SCENES = ("planar_pendulum", "spatial_pendulum")
LINKS = (4, 6, 8, 10, 14, 20, 28, 40, 56, 68)
LONG = 40  # links from which on the step has no influence left, and what is costly is not repeated
TUNED_INERTIA = 8.0 / 7.0  # over a uniform rod's: about the least error on both scenes, 3/4 to 3/2 tried
LOW_ORDER = {"Euler": (6, 10, 14), "implicitfast": (6, 10), "discrete": (6, 10, 20)}
LOW_ORDER_FRACTIONS = (0.95, 0.25, 0.05)
NOT_INSTALLED = "MuJoCo is not installed: no rows of rigid links; pip install 'exudyn_inext[peers]'."


def links_cases(scene: Scene) -> Iterator[Case]:
    """Over links, steps, integrators and the rotary inertia of a link; none if MuJoCo is not installed."""
    if scene.name not in LINKED_SCENES or not rigid_links.is_installed():
        return
    for links in LINKS:
        fractions = FRACTIONS[:1] if links >= LONG else FRACTIONS
        for inertia in (TUNED_INERTIA,) if links > LONG else (1.0, TUNED_INERTIA):
            yield from _links(scene, RigidLinks(links, 1.0, rotary_inertia=inertia), fractions)
    for integrator in filter(rigid_links.has_integrator, LOW_ORDER):
        for links in LOW_ORDER[integrator]:
            chain_of_links = RigidLinks(links, 1.0, integrator, TUNED_INERTIA)
            yield from _links(scene, chain_of_links, LOW_ORDER_FRACTIONS)


def _links(scene: Scene, links: RigidLinks, fractions: Sequence[float]) -> Iterator[Case]:
    """At fractions of the stability limit; of Euler's, for integrators that have none."""
    limit = rigid_links.largest_step(scene, links)
    if math.isinf(limit):
        limit = rigid_links.largest_step(scene, replace(links, integrator="Euler"))
    for fraction in fractions:
        yield rigid_links.rigid_links_case(scene, replace(links, step_size=fraction * limit))
