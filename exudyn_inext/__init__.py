"""Inextensible ANCF cables for Exudyn, moved by explicit integrators."""

from typing import Any
from warnings import warn

from .errors import (
    DivergenceError,
    EnforcementError,
    EquilibriumError,
    ExplicitTrapWarning,
    InextensibleError,
    InputError,
    RedundantConstraintError,
    SceneError,
    StepSizeError,
)
from .exudyn_binding.advising.advise import AdviceSettings, Advise
from .exudyn_binding.cable_forces import CableForces, CreateCableEnergySensor, CreateCableForceSensor
from .exudyn_binding.eigenvalues import ComputeEigenvalues
from .exudyn_binding.ensemble import SolveEnsemble
from .exudyn_binding.explicit_solver import ExplicitSolver
from .exudyn_binding.explicit_steps import ExplicitSteps
from .exudyn_binding.solver import SolveExplicit
from .exudyn_binding.static_solver import SolveEquilibrium, StaticSettings
from .exudyn_binding.stepper import ExplicitStepper
from .integrators.rattle import Rattle
from .integrators.runge_kutta import RungeKutta4
from .integrators.zhai import Zhai
from .items.attach.attach_to_body import AttachToBody
from .items.attach.companions import AddMarkerOnCable, CreateCompanionCables
from .items.attach.properties import AddPointMass, CableDrag, SetCableDrag
from .items.cable_item import CreateInextensibleCable
from .items.enforcement.algebraic import Algebraic
from .items.enforcement.penalty_mass import PenaltyMass
from .items.enforcement.projection import Projection
from .items.explicit_traps import WarnOfExplicitTraps
from .items.prescribed_motion import CreatePrescribedMotion
from .items.replace_native import ReplaceNativeCables
from .items.shape import CableShape
from .items.template import InextensibleCable
from .run.settings import ExplicitSettings

__version__ = "0.1.0"

__all__ = [
    "AddMarkerOnCable",
    "AddPointMass",
    "AdviceSettings",
    "Advise",
    "Algebraic",
    "AttachToBody",
    "CableDrag",
    "CableForces",
    "CableShape",
    "ComputeEigenvalues",
    "CreateCableEnergySensor",
    "CreateCableForceSensor",
    "CreateCompanionCables",
    "CreateInextensibleCable",
    "CreatePrescribedMotion",
    "DivergenceError",
    "EnforcementError",
    "EquilibriumError",
    "ExplicitSettings",
    "ExplicitSolver",
    "ExplicitStepper",
    "ExplicitSteps",
    "ExplicitTrapWarning",
    "InextensibleCable",
    "InextensibleError",
    "InputError",
    "PenaltyMass",
    "Projection",
    "Rattle",
    "RedundantConstraintError",
    "ReplaceNativeCables",
    "RungeKutta4",
    "SceneError",
    "SetCableDrag",
    "SolveEnsemble",
    "SolveEquilibrium",
    "SolveExplicit",
    "StaticSettings",
    "StepSizeError",
    "WarnOfExplicitTraps",
    "Zhai",
]

_RENAMED = {"MarkerOnCable": "AddMarkerOnCable"}  # until the release after 0.1


def __getattr__(name: str) -> Any:
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    warn(f"exudyn_inext.{name} is deprecated: use {_RENAMED[name]}.", DeprecationWarning, stacklevel=2)
    return globals()[_RENAMED[name]]
