"""One change at a time, on the paper's scenes, timed against the base in turn."""

import math
from dataclasses import replace
from functools import lru_cache

from exudyn_inext import ExplicitSettings, Zhai
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.scenes import Scene, load_scene
from reference_models.trajectory import Case
from studies.harness.cases import failing_case
from studies.harness.reference import ReferenceSolution, from_data
from studies.harness.rows import make_row
from studies.harness.study import Row
from studies.harness.timing import measure
from studies.table3 import refined

SCENES = {"planar_pendulum": 8, "spatial_pendulum": 8, "vibrating_ring": 16, "power_line": 16}  # elements
PART = 0.6  # of the stability limit: what a model's own limit costs is a part of its price
QUICK_MOTION = 0.5  # [s]
NOT_QUICK = ("measure: product", "RK4")  # kernels of their own, which take long to compile
REPEATS, QUICK_REPEATS = 5, 2

BASE: Row = {
    "integrator": "Zhai",
    "zeta": 100.0,
    "measure": "secondDerivative",
    "lengthConstraints": None,
    "spatial": False,
    "projectedRate": True,
    "corrector": False,
    "psi": 0.5,
}


def changes_of(scene: Scene, elements: int) -> dict[str, Row]:
    """Label -> what differs from the base."""
    half = elements // 2
    changes: dict[str, Row] = {
        "measure: product": {"measure": "product"},
        "n_bar = 0": {"lengthConstraints": 0},
        "n_bar = 1": {"lengthConstraints": 1},
        "n_bar = 2": {"lengthConstraints": 2},
        "n_bar = N / 2": {"lengthConstraints": half},
        "n_bar = N - 1": {"lengthConstraints": elements - 1},
        "v_n, not the projected rate": {"projectedRate": False},
        "zeta = 10": {"zeta": 10.0},
        "zeta = 300": {"zeta": 300.0},
        "corrector, psi = phi = 0": {"corrector": True, "psi": 0.0},
        "RATTLE": {"integrator": "RATTLE"},
        "RK4": {"integrator": "RK4"},
        "half as many elements": {"elements": half},
        "twice as many elements": {"elements": 2 * elements},
    }
    if scene.is_planar:
        changes["3D, not 2D"] = {"spatial": True}
    return changes


def change_cases(quick: bool) -> list[Row]:
    """Timed, each beside the base."""
    names = ("planar_pendulum",) if quick else tuple(SCENES)
    return [
        {
            "kind": "change",
            "scene": name,
            "label": label,
            "elements": SCENES[name],
            "change": change,
            "motion": QUICK_MOTION if quick else load_scene(name).end_time,
            "repeats": QUICK_REPEATS if quick else REPEATS,
            "timed": True,
        }
        for name in names
        for label, change in changes_of(load_scene(name), SCENES[name]).items()
        if not (quick and label in NOT_QUICK)
    ]


def run_change(case: Row) -> Row:
    """Errors and CPU times of base and variant, run in turn."""
    scene = replace(load_scene(case["scene"]), end_time=case["motion"])
    base = {**BASE, "elements": case["elements"]}
    cases = [_case(scene, base, "base"), _case(scene, base | case["change"], "variant")]
    reference = _reference(case["scene"])
    first, second = (make_row(m, reference.trajectory) for m in measure(cases, case["repeats"]))
    return {
        "uncertainty": reference.uncertainty,
        "baseError": first["errorMax"],
        "baseSeconds": first["cpuSeconds"],
        "baseStep": first["stepSize"],
        "baseOutcome": first["status"],
        "error": second["errorMax"],
        "seconds": second["cpuSeconds"],
        "stepSize": second["stepSize"],
        "errorRatio": _ratio(second["errorMax"], first["errorMax"]),
        "costRatio": _ratio(second["cpuSeconds"], first["cpuSeconds"]),
        "outcome": second["status"],
    }


def _ratio(value: float | None, base: float | None) -> float | None:
    return value / base if value is not None and base else None


def _case(scene: Scene, given: Row, label: str) -> Case:
    """At PART of its own stability limit; one that cannot even start fails when it is run."""
    try:
        limits = inextensible_case(_brief(scene), _model(given, _settings(given)))
        settings = _settings(given, PART * limits.details["stepLimit"])
        return inextensible_case(scene, _model(given, settings), label)
    except ArithmeticError as error:
        return failing_case(label, given["integrator"], given["elements"], error)


def _brief(scene: Scene) -> Scene:
    return replace(scene, end_time=0.01)


def _settings(given: Row, step: float | None = None) -> ExplicitSettings:
    scheme = None
    if given["integrator"] == "Zhai":
        psi = given["psi"]
        scheme = Zhai(psi, psi, given["corrector"], projected_rate=given["projectedRate"])
    return ExplicitSettings(
        given["integrator"],
        scheme,
        stepSize=step,
        stabilizationRate=given["zeta"],
        massScaling=0.0,
        energyTolerance=math.inf,  # errors are measured, not guarded against
    )


def _model(given: Row, settings: ExplicitSettings) -> Inextensible:
    return Inextensible(
        given["elements"],
        settings,
        measure=given["measure"],
        length_constraints=given["lengthConstraints"],
        spatial=given["spatial"],
    )


@lru_cache
def _reference(name: str) -> ReferenceSolution:
    scene = load_scene(name)
    return from_data(scene) if scene.reference else refined(scene)
