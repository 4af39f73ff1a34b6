"""Inextensible cables under explicit steps: every scheme, on many meshes, below its stability limit.

Runs are not ended for their energy: it is their errors that are measured.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from exudyn_inext import ExplicitSettings, Zhai
from reference_models.inextensible import Inextensible
from reference_models.scenes import Scene
from reference_models.trajectory import Case
from studies import ring, table1, table2, table3
from studies.harness.cases import kept_case

from .selection import Selection

FRACTIONS = (0.95, 0.5)  # of the stability limit
SCHEMES: dict[str, tuple[str, Zhai | None]] = {
    "Zhai": ("Zhai", None),
    "Zhai with corrector": ("Zhai", Zhai(0.0, 0.0, corrector=True)),
    "RK4": ("RK4", None),
    "RATTLE": ("RATTLE", None),
}
EXTRA_THETA, COARSE = 0.3, 2.5e-3  # RATTLE takes this theta, too, from this step on [s]
SCALED = (("Zhai", 0.3), ("RATTLE", 0.25), ("RATTLE", EXTRA_THETA))
DECAY = 0.6  # most of h zeta; Zhai's limit is 1


@dataclass(frozen=True)
class Meshes:
    """Numbers of elements: at the stability limits, and with scaled mass; the steps of the latter [s].

    coarse: elements and steps [s] of scaled rows that are cheap rather than accurate.   zeta [1/s]: of Zhai.
    """

    limited: Sequence[int]
    scaled: Sequence[int]
    steps: Sequence[float]
    coarse: Sequence[tuple[int, float]]
    zeta: float = 100.0


_PENDULUM = Meshes(
    (3, 4, 5, 6, 8, 10, 14, 20),
    (3, 4, 5, 6, 8, 10, 14, 20, 28),
    (5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
    ((2, 1e-2), (2, 5e-3), (3, 1e-2), (4, 1e-2), (5, 1e-2), (4, 3.34e-3), (5, 3.34e-3), (6, 3.34e-3)),
)
MESHES = {
    "planar_pendulum": _PENDULUM,
    "spatial_pendulum": replace(_PENDULUM, zeta=150.0),
    "vibrating_ring": Meshes(
        (6, 8, 10, 12, 16, 20, 28),
        (8, 10, 12, 14, 16, 20, 28, 40),
        (2e-3, 1e-3, 5e-4, 2.5e-4),
        ((6, 5e-3), (6, 3.34e-3), (8, 3.34e-3), (8, 5e-3), (10, 3.34e-3)),
        zeta=300.0,
    ),
    "power_line": Meshes(
        (4, 8, 12, 16, 20, 28, 40),
        (8, 12, 16, 20, 28, 40, 60),
        (5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
        ((4, 1e-2), (4, 5e-3), (8, 1e-2), (12, 1e-2), (16, 1e-2)),
        zeta=300.0,
    ),
}
QUICK = Meshes((5,), (5, 8), (5e-3, 2.5e-3), ((3, 1e-2),))
QUICK_BY_FOURS = Meshes((8,), (8, 12), (5e-3, 2.5e-3), ((8, 1e-2),))
TUNED = {
    "planar_pendulum": table1.inextensible_cases,
    "spatial_pendulum": table2.inextensible_cases,
    "vibrating_ring": ring.inextensible_cases,
    "power_line": table3.inextensible_cases,
}


def inextensible_selection(scene: Scene, quick: bool) -> Selection:
    """All of them for a scene, the tuned ones of the tables included."""
    selection = Selection()
    meshes = MESHES[scene.name]
    if quick:
        meshes = QUICK if scene.name.endswith("pendulum") else QUICK_BY_FOURS
    else:
        selection.add(*TUNED[scene.name](scene))
    for elements in meshes.limited:
        for name in SCHEMES:
            selection.add(*_limited_cases(scene, elements, name))
    pairs = [(n, h) for n in meshes.scaled for h in meshes.steps] + list(meshes.coarse)
    for elements, step_size in pairs:
        for integrator, theta in SCALED:
            if theta == EXTRA_THETA and integrator == "RATTLE" and step_size < COARSE:
                continue
            zeta = min(meshes.zeta, DECAY / step_size)
            selection.add(_case(scene, elements, _scaled(integrator, theta, step_size, zeta)))
    return selection


def _scaled(integrator: str, theta: float, step_size: float, zeta: float) -> ExplicitSettings:
    settings = ExplicitSettings(integrator, stepSize=step_size, massScaling=theta, energyTolerance=math.inf)
    return replace(settings, stabilizationRate=zeta) if integrator == "Zhai" else settings


def _limited_cases(scene: Scene, elements: int, name: str) -> list[Case]:
    """At fractions of the stability limit."""
    integrator, scheme = SCHEMES[name]
    settings = ExplicitSettings(integrator, scheme, massScaling=0.0, energyTolerance=math.inf)
    brief = _case(replace(scene, end_time=0.01), elements, settings)
    limit = brief.details.get("stepLimit")
    if limit is None:
        return [brief]
    return [_case(scene, elements, replace(settings, stepSize=x * limit)) for x in FRACTIONS]


def _case(scene: Scene, elements: int, settings: ExplicitSettings) -> Case:
    """One that diverges, or is refused, keeps its place."""
    case = kept_case(scene, Inextensible(elements, settings))
    corrector = settings.scheme is not None and settings.scheme.corrector
    details = {"massScaling": settings.massScaling, **case.details, "corrector": corrector}
    return replace(case, details=details)
