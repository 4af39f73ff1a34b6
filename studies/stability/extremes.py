"""Maps at the extremes: slender native cables, violent starts, single precision."""

import math
import warnings
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import exudyn
import numpy as np
from scipy.linalg import eigh

from exudyn_inext import DivergenceError, ExplicitSettings, SolveExplicit
from reference_models.conventional.model import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import load_scene
from reference_models.scenes.section import Section
from reference_models.trajectory import Array
from studies.harness import Row, inner

from .limits import DISTURBANCE, GROWTH, distance, largest_stable_step, predict
from .motion import (
    DENSITY,
    GRAVITY,
    LENGTH,
    SCHEMES,
    STIFFNESS,
    Equilibrium,
    Invariants,
    Method,
    Motion,
    sagging,
    straight,
)


def cases(quick: bool) -> Iterator[Row]:
    """Of all three.   value: EA / EI [1/m^2]; largest velocity at the start [m/s]; N."""
    plain = ("Zhai", "RATTLE", "RK4")
    ratios, steps = ((1e2, 1e6, 1e10), 600) if quick else ([10.0**k for k in range(2, 11)], 2000)
    for scheme, ratio in product(plain, ratios):
        case = {"kind": "slenderness", "label": scheme, "scheme": scheme}
        yield case | {"value": ratio, "steps": steps}
    methods, speeds = (METHODS[1::4], (1.0, 30.0)) if quick else (METHODS, SPEEDS)
    for (scheme, zeta), speed in product(methods, speeds):
        label = f"{scheme}, zeta = {zeta:g} 1/s" if scheme != "RATTLE" else scheme
        case = {"kind": "violent", "label": label, "scheme": scheme, "zeta": zeta}
        yield case | {"value": speed, "duration": 0.1 if quick else DURATION}
    numbers = (5, 20) if quick else (5, 10, 20, 50, 100, 200, 400)
    for scheme, bits, number in product(plain, (32, 64), numbers):
        case = {"kind": "precision", "label": f"{scheme}, {bits} bit", "scheme": scheme}
        yield case | {"bits": bits, "value": number}


# ------------------ axial waves against bending, over EA / EI, under the same explicit integrators


SLENDER_ELEMENTS = 6
_SCENE = replace(load_scene("planar_pendulum"), gravity=(0.0, 0.0, 0.0))


def run_slenderness(case: Row) -> Row:
    """Predicted and bisected limit of native cables, and that of as many inextensible elements."""
    section = Section(DENSITY, STIFFNESS, case["value"] * STIFFNESS)
    model = build(replace(_SCENE, cable=replace(_SCENE.cable, section=section)), SLENDER_ELEMENTS)
    name, scheme = SCHEMES[case["scheme"]]
    frequency, vibration = fastest_vibration(model)
    predicted = inner.frequency_limit(inner.find_integrator(name), scheme) / frequency
    settings = ExplicitSettings(scheme or name)
    random = 0.1 * np.random.default_rng(1).uniform(-1.0, 1.0, len(vibration))
    random[:2] = 0.0
    disturbance = vibration / np.abs(vibration).max() + random
    found = largest_step_at_rest(model.mbs, disturbance, settings, case["steps"], predicted)
    inextensible = predict(straight(SLENDER_ELEMENTS), Method(case["scheme"], zeta=1.0)).bending
    axial = np.abs(vibration.reshape(-1, 2)[:, 0]).max() > np.abs(vibration.reshape(-1, 2)[:, 1]).max()
    return {
        "largestFrequency": frequency,
        "predicted": predicted,
        "found": found,
        "ratio": found / predicted,
        "ruledBy": "axial waves" if axial else "bending",
        "inextensible": inextensible,
        "gain": inextensible / found,
    }


def largest_step_at_rest(
    mbs: Any, disturbance: Array, settings: ExplicitSettings, steps: int, estimate: float
) -> float:
    """Largest step [s] at which a disturbance of a scene at rest does not grow over so many steps.

    disturbance: (n_dof,) of the coordinates, of size 1 [m, -]; it is scaled.   estimate: of the step [s].
    """
    data = mbs.systemData
    settings = replace(settings, allowUnstableStep=True, rejectSteps=False)

    def is_stable(h: float) -> bool:
        """Whether the largest displacement at the end [m, -] is small."""
        data.SetODE2Coordinates(DISTURBANCE * disturbance, exudyn.ConfigurationType.Initial)
        end = steps * h
        with warnings.catch_warnings(), silence():
            warnings.simplefilter("ignore", UserWarning)  # the step is above the limit on purpose
            try:
                SolveExplicit(mbs, quiet_settings(end, 1, period=end), replace(settings, stepSize=h))
            except DivergenceError:
                return False
        return float(np.abs(data.GetODE2Coordinates()).max()) < GROWTH * DISTURBANCE

    return largest_stable_step(is_stable, estimate)


def fastest_vibration(model: Model) -> tuple[float, Array]:
    """w_max [rad/s] and its vibration (n_dof,), zero at the pin."""
    mass, stiffness, _ = model.mbs.ComputeLinearizedSystem()
    free = np.arange(2, len(mass))  # the pin holds the first node's position
    squares, vectors = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
    vibration = np.zeros(len(mass))
    vibration[free] = vectors[:, -1]
    return float(np.sqrt(squares[-1])), vibration


# ----------------------------------- a cable that is thrown: how much of the limit at rest remains


SPEEDS = (1.0, 3.0, 10.0, 30.0, 100.0)  # [m/s]
METHODS = (
    ("Zhai", 10.0),
    ("Zhai", 100.0),
    ("Zhai", 300.0),
    ("Zhai, corrector, psi = phi = 0", 100.0),
    ("RK4", 100.0),
    ("RATTLE", 100.0),
)
ELEMENTS, DURATION = 10, 1.0  # [-], [s]
STEPS_A_FACTOR = 4  # tried steps within a factor of two
HALVINGS = 6
ENERGY = 0.05  # change over the kinetic energy at the start that is no divergence yet
FINE = 8  # part of the limit at which the motion's frequency is looked at


def thrown(speed: float) -> Equilibrium:
    """A pinned straight cable under gravity in which one wave and a half run up and down."""
    start = straight(ELEMENTS)
    x = start.q[:, 0, 0]
    v = np.zeros_like(start.q)
    v[:, 0, 1] = speed * np.sin(3.0 * np.pi * x / LENGTH)
    v[:, 1, 1] = speed * 3.0 * np.pi / LENGTH * np.cos(3.0 * np.pi * x / LENGTH)
    force = inner.gravity_force(start.cable, np.array([0.0, -GRAVITY]))
    q, velocity = start.q.ravel().copy(), v.ravel()
    inner.settle(Method("RATTLE").system(start.cable, 0.0), force.ravel(), q, velocity)
    return Equilibrium(start.cable, q.reshape(v.shape), velocity.reshape(v.shape), force)


def run_violent(case: Row) -> Row:
    """The largest step that lasts, beside the limit at rest and that of the motion's own w_max."""
    start, method = thrown(case["value"]), Method.of(case)
    at_rest = predict(straight(ELEMENTS), method).step
    limit = inner.frequency_limit(method.integrator, method.parameters)
    frequency = _largest_in_motion(start, at_rest / FINE, case["duration"])
    in_motion = min(limit / frequency, predict(straight(ELEMENTS), method).stabilisation)
    lasting = 0.0
    for k in range(-HALVINGS * STEPS_A_FACTOR, 1):
        h = at_rest * 2.0 ** (k / STEPS_A_FACTOR)
        if not _lasts(start, method, h, case["duration"]):
            break
        lasting = h
    return {
        "predicted": at_rest,
        "predictedInMotion": in_motion,
        "found": lasting,
        "part": lasting / at_rest,
        "partOfMotion": lasting / in_motion,
        "largestFrequency": frequency,
    }


def _largest_in_motion(start: Equilibrium, h: float, duration: float) -> float:
    """Largest w_max [rad/s] on the way of RATTLE with small steps."""
    method = Method("RATTLE")
    motion, system = Motion(start, method, h), method.system(start.cable, 0.0)
    samples = 100
    found = [inner.largest_frequency(system, start.inputs, start.q, start.v)]
    while motion.steps * h < duration and motion.advance(max(1, round(duration / h / samples))):
        found.append(inner.largest_frequency(system, start.inputs, motion.q, motion.v))
    return max(w for w in found if math.isfinite(w))


def _lasts(start: Equilibrium, method: Method, h: float, duration: float) -> bool:
    """Whether the run stays on the constraints and keeps its energy."""
    motion, invariants = Motion(start, method, h), Invariants(start.cable, start.external)
    energy, scale = invariants.energy(start.q, start.v), invariants.kinetic(start.v)
    weight: Array = np.abs(start.external[:, 0]).sum(axis=0)
    scale += float(weight.sum()) * LENGTH
    while motion.steps * h < duration:
        if not motion.advance(50):
            return False
        if not abs(invariants.energy(motion.q, motion.v) - energy) < ENERGY * scale:
            return False
    return True


# ----------- the state is rounded to float32 after every step, the solves stay in double precision


STEPS = 2000
SHARE = 0.9  # span over length
BLOWN_UP = 1e-2  # distance from the equilibrium: slopes [-], positions over the element length
HALF = 0.5  # part of the limit at which noise is measured


class RoundedMotion(Motion):
    """A motion whose coordinates and velocities are stored in single precision between steps."""

    def advance(self, steps: int) -> bool:
        """Take the steps one by one."""
        for _ in range(steps):
            if not super().advance(1):
                return False
            with np.errstate(over="ignore"):  # of a run that diverges
                for values in (self.state.q, self.state.v):
                    values[:] = values.astype(np.float32)
        return True


def run_precision(case: Row) -> Row:
    """Noise about the equilibrium of a sagging cable, and the largest step at which it stays small."""
    start: Equilibrium = sagging(case["value"], SHARE)
    method = Method(case["scheme"], zeta=10.0)
    predicted = predict(start, method).step
    kind, measure = (RoundedMotion if case["bits"] == 32 else Motion), distance(start)

    def noise(h: float) -> float:
        motion, largest = kind(start, method, h), 0.0
        while motion.steps < STEPS:
            if not motion.advance(100):
                return float("inf")
            largest = max(largest, measure(motion.q, start.q))
        return largest

    found = largest_stable_step(lambda h: noise(h) < BLOWN_UP, predicted, 1e-2)
    return {
        "predicted": predicted,
        "found": found,
        "ratio": found / predicted,
        "noise": noise(HALF * predicted),
    }
