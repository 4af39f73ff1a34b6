"""Long runs: drift of energy, constraints and momentum; what decides whether Zhai survives."""

from dataclasses import replace

import numpy as np

from studies.harness import Row
from studies.harness.inner import CurvatureMeasure, gravity_force, largest_frequency

from .limits import predict
from .motion import GRAVITY, LENGTH, Equilibrium, Invariants, Method, Motion, straight

ELEMENTS = 5
SWING_PART = 0.95  # of the limit at rest: the base
PORTION = 500  # steps between two looks at the energy
WINDOW = 40  # looks at the frequency before the end

BASE: Row = {
    "scheme": "Zhai",
    "zeta": 100.0,
    "part": SWING_PART,
    "measure": "secondDerivative",
    "angle": 90.0,
}
CHANGES: dict[str, Row] = {
    "base: 0.95 of the limit, zeta = 100": {},
    "half the step": {"part": SWING_PART / 2},
    "a quarter of the step": {"part": SWING_PART / 4},
    "an eighth of the step": {"part": SWING_PART / 8},
    "zeta = 10": {"zeta": 10.0},
    "zeta = 30": {"zeta": 30.0},
    "zeta = 300": {"zeta": 300.0},
    "v_n, not the projected rate": {"scheme": "Zhai, v_n"},
    "measure product": {"measure": "product"},
    "swing from 30 degrees": {"angle": 30.0},
    "swing from 10 degrees": {"angle": 10.0},
    "corrector, psi = phi = 0": {"scheme": "Zhai, corrector, psi = phi = 0"},
    "RK4": {"scheme": "RK4"},
    "RATTLE": {"scheme": "RATTLE"},
}
LONGEST = ("an eighth of the step", "RK4", "RATTLE")
QUICK = ("base: 0.95 of the limit, zeta = 100", "a quarter of the step", "RK4", "RATTLE")


def long_cases(quick: bool) -> list[Row]:
    """The pendulum with one change at a time, and the free flight of a bent cable; value: steps."""
    steps = 20_000 if quick else 1_000_000
    pendulums = [_case("pendulum", name, steps) for name in (QUICK if quick else CHANGES)]
    flights = [_case("free flight", name, steps) for name in ("a quarter of the step", "RK4", "RATTLE")]
    longest = [] if quick else [_case("pendulum", name, 10_000_000) for name in LONGEST]
    return pendulums + flights + longest


def _case(scene: str, name: str, steps: int) -> Row:
    return {"kind": "long", "label": name, "scene": scene, "value": steps, **BASE, **CHANGES[name]}


def pendulum_of(
    elements: int, angle: float = 90.0, measure: str = CurvatureMeasure.SECOND_DERIVATIVE.value
) -> Equilibrium:
    """Straight, pinned, at rest, that many degrees off the vertical."""
    start = straight(elements)
    direction = np.array([np.sin(np.radians(angle)), -np.cos(np.radians(angle))])
    q = start.q[..., :1] * direction
    cable = replace(start.cable, reference=q, measure=CurvatureMeasure(measure))
    return Equilibrium(cable, q, np.zeros_like(q), gravity_force(cable, np.array([0.0, -GRAVITY])))


def flight(measure: str) -> Equilibrium:
    """Straight, free of supports and loads; it turns, moves, and bends."""
    start = straight(ELEMENTS)
    cable = replace(start.cable, fixed=np.zeros_like(start.cable.fixed), measure=CurvatureMeasure(measure))
    x = start.q[:, 0, 0] / LENGTH
    v = np.zeros_like(start.q)
    v[:, 0, 1] = 2.0 * x + np.cos(2.0 * np.pi * x)
    v[:, 1, 1] = (2.0 - 2.0 * np.pi * np.sin(2.0 * np.pi * x)) / LENGTH
    return Equilibrium(cable, start.q, v, np.zeros_like(v))


def run_long(case: Row) -> Row:
    """Drifts, and where the run ended; energies over the largest kinetic energy."""
    measure = case["measure"]
    start = pendulum_of(ELEMENTS, case["angle"], measure) if case["scene"] == "pendulum" else flight(measure)
    method = Method.of(case)
    limit = predict(replace(start, v=np.zeros_like(start.v)), method)
    h = case["part"] * limit.step
    motion, invariants = Motion(start, method, h), Invariants(start.cable, start.external)
    energies, kinetic = [invariants.energy(motion.q, motion.v)], [invariants.kinetic(motion.v)]
    momenta = invariants.momenta(motion.q, motion.v)
    last, fastest = (motion.q.copy(), motion.v.copy()), 0.0
    survives, system = True, method.system(start.cable, 0.0)
    while motion.steps < case["value"] and (survives := motion.advance(PORTION)):
        last = motion.q.copy(), motion.v.copy()
        energies.append(invariants.energy(*last))
        kinetic.append(invariants.kinetic(last[1]))
        if motion.steps % (case["value"] // WINDOW) < PORTION:
            fastest = max(fastest, largest_frequency(system, start.inputs, *last))
    if not survives:
        fastest = max(fastest, largest_frequency(system, start.inputs, *last))
    swing = max(kinetic)
    drift = (np.array(energies) - energies[0]) / swing
    linear, angular = invariants.momenta(*last)
    flies = case["scene"] != "pendulum"
    return {
        "stepSize": h,
        "survives": survives,
        "steps": motion.steps,
        "seconds": motion.steps * h,
        "energyMax": float(np.abs(drift).max()),
        "energyDrift": float(drift[-len(drift) // 10 :].mean() - drift[: max(1, len(drift) // 10)].mean()),
        "violation": invariants.violation(last[0]),
        "momentum": float(np.abs(linear - momenta[0]).max()) if flies else None,
        "angularMomentum": abs(angular / momenta[1] - 1.0) if flies else None,
        "frequencyOverLimit": float(h * fastest / (limit.bending * limit.frequency)),
    }
