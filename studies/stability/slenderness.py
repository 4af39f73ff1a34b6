"""Conventional cables: axial waves against bending, over EA / EI, under the same explicit integrators."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

from exudyn_inext import DivergenceError, ExplicitSettings, SolveExplicit
from exudyn_inext.arrays import Array
from exudyn_inext.integrators import find_integrator
from exudyn_inext.integrators.linear_stability import frequency_limit
from reference_models.conventional.model import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import load_scene
from reference_models.scenes.section import Section
from studies.harness.study import Row

from .bisection import DISTURBANCE, GROWTH, largest_stable_step
from .cables import DENSITY, STIFFNESS, straight
from .motion import SCHEMES, Method
from .prediction import predict

ELEMENTS = 6
_SCENE = replace(load_scene("planar_pendulum"), gravity=(0.0, 0.0, 0.0))


def slenderness_cases(quick: bool) -> list[Row]:
    """value: EA / EI [1/m^2]."""
    ratios = (1e2, 1e6, 1e10) if quick else tuple(10.0**k for k in range(2, 11))
    steps = 600 if quick else 2000
    return [
        {"kind": "slenderness", "label": scheme, "scheme": scheme, "value": ratio, "steps": steps}
        for scheme in ("Zhai", "RATTLE", "RK4")
        for ratio in ratios
    ]


def run_slenderness(case: Row) -> Row:
    """Predicted and bisected limit of native cables, and that of as many inextensible elements."""
    section = Section(DENSITY, STIFFNESS, case["value"] * STIFFNESS)
    model = build(replace(_SCENE, cable=replace(_SCENE.cable, section=section)), ELEMENTS)
    name, scheme = SCHEMES[case["scheme"]]
    frequency, vibration = fastest_vibration(model)
    predicted = frequency_limit(find_integrator(name), scheme) / frequency
    settings = ExplicitSettings(name, scheme, allowUnstableStep=True, rejectSteps=False)
    disturbance = DISTURBANCE * vibration / np.abs(vibration).max()

    def is_stable(h: float) -> bool:
        moved = _moved(model, disturbance, replace(settings, stepSize=h), case["steps"])
        return moved < GROWTH * DISTURBANCE

    found = largest_stable_step(is_stable, predicted)
    inextensible = predict(straight(ELEMENTS), Method(case["scheme"], zeta=1.0)).bending
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


def fastest_vibration(model: Model) -> tuple[float, Array]:
    """w_max [rad/s] and its vibration (n_dof,), zero at the pin."""
    mass, stiffness, _ = model.mbs.ComputeLinearizedSystem()
    free = np.arange(2, len(mass))  # the pin holds the first node's position
    squares, vectors = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
    vibration = np.zeros(len(mass))
    vibration[free] = vectors[:, -1]
    return float(np.sqrt(squares[-1])), vibration


def _moved(model: Model, disturbance: Array, settings: ExplicitSettings, steps: int) -> float:
    """Largest displacement at the end [m, -]; infinite after a divergence."""
    data: Any = model.mbs.systemData
    random = 0.1 * DISTURBANCE * np.random.default_rng(1).uniform(-1.0, 1.0, len(disturbance))
    random[:2] = 0.0
    data.SetODE2Coordinates(disturbance + random, _initial())
    h = float(settings.stepSize or 0.0)
    with warnings.catch_warnings(), silence():
        warnings.simplefilter("ignore", UserWarning)  # the step is above the limit on purpose
        try:
            SolveExplicit(model.mbs, quiet_settings(steps * h, 1, period=steps * h), settings)
        except DivergenceError:
            return float("inf")
    return float(np.abs(data.GetODE2Coordinates()).max())


def _initial() -> Any:
    import exudyn

    return exudyn.ConfigurationType.Initial
