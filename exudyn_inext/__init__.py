"""Inextensible ANCF cables for Exudyn, moved by explicit integrators."""

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
from .exudyn_binding.attach.attach_to_body import AttachToBody
from .exudyn_binding.attach.companions import CreateCompanionCables, MarkerOnCable
from .exudyn_binding.attach.properties import AddPointMass, CableDrag, SetCableDrag
from .exudyn_binding.cable_forces import CableForces, CreateCableForceSensor
from .exudyn_binding.cable_item import CreateInextensibleCable
from .exudyn_binding.enforcement.algebraic import Algebraic
from .exudyn_binding.enforcement.penalty_mass import PenaltyMass
from .exudyn_binding.enforcement.projection import Projection
from .exudyn_binding.ensemble import SolveEnsemble
from .exudyn_binding.explicit_traps import WarnOfExplicitTraps
from .exudyn_binding.prescribed_motion import CreatePrescribedMotion
from .exudyn_binding.settings import ExplicitSettings
from .exudyn_binding.shape import CableShape
from .exudyn_binding.solver import SolveExplicit
from .exudyn_binding.static_solver import SolveEquilibrium, StaticSettings
from .exudyn_binding.stepper import ExplicitStepper
from .exudyn_binding.template import InextensibleCable
from .integrators.rattle import Rattle
from .integrators.runge_kutta import RungeKutta4
from .integrators.zhai import Zhai

__all__ = [
    "AddPointMass",
    "AdviceSettings",
    "Advise",
    "Algebraic",
    "AttachToBody",
    "CableDrag",
    "CableForces",
    "CableShape",
    "CreateCableForceSensor",
    "CreateCompanionCables",
    "CreateInextensibleCable",
    "CreatePrescribedMotion",
    "DivergenceError",
    "EnforcementError",
    "EquilibriumError",
    "ExplicitSettings",
    "ExplicitStepper",
    "ExplicitTrapWarning",
    "InextensibleCable",
    "InextensibleError",
    "InputError",
    "MarkerOnCable",
    "PenaltyMass",
    "Projection",
    "Rattle",
    "RedundantConstraintError",
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
