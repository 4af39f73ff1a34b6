"""A scene as an inextensible cable, moved by the plugin's explicit integrators."""

from dataclasses import dataclass, field
from typing import Any

import exudyn

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SolveExplicit,
)
from exudyn_inext.errors import InputError

from .model import SENSOR_PERIOD, Model, add_position_sensors, quiet_settings, sensor_trajectory, silence
from .scenes import Clamp, Scene
from .trajectory import Case, Run, Trajectory


@dataclass(frozen=True)
class Inextensible:
    """What distinguishes one inextensible run from another.

    elements: N.   settings: of SolveExplicit.   output_period: between two steps of Exudyn's loop [s];
    None: the sensors' period.   measure: curvature measure.
    """

    elements: int
    settings: ExplicitSettings = field(default_factory=ExplicitSettings)
    output_period: float | None = None
    measure: str = "secondDerivative"


def build(scene: Scene, elements: int, measure: str = "secondDerivative") -> Model:
    """Build and assemble the scene with one inextensible cable of equal elements."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    section = scene.cable.section
    start, end = _ground_constraints(scene)
    cable = CreateInextensibleCable(
        mbs,
        beamTemplate=InextensibleCable(
            section.mass_per_length, section.bending_stiffness, curvatureMeasure=measure
        ),
        gravity=scene.gravity,
        groundConstraintsStart=start,
        groundConstraintsEnd=end,
        shape=_shape(scene, elements),
    )
    sensors = add_position_sensors(mbs, scene, cable["nodes"])
    mbs.Assemble()
    return Model(scene, container, mbs, tuple(cable["nodes"]), sensors)


def _shape(scene: Scene, elements: int) -> CableShape:
    line, length = scene.cable.shape, scene.cable.length
    end = [a + length * d for a, d in zip(line.start, line.direction, strict=True)]
    return CableShape.Line(line.start, end, elements, velocityEnd=scene.end_velocity)


def _ground_constraints(scene: Scene) -> tuple[list[bool] | None, list[bool] | None]:
    """Flags of the first and the last node."""
    dimension = 2 if scene.is_planar else 3
    flags: dict[float, list[bool]] = {}
    for support in scene.supports:
        if support.at not in (0.0, 1.0):
            raise InputError(f"{support}: supports are at the ends, at 0.0 or 1.0.")
        flags[support.at] = [True] * dimension + [isinstance(support, Clamp)] * dimension
    return flags.get(0.0), flags.get(1.0)


def inextensible_case(scene: Scene, model: Inextensible, label: str = "") -> Case:
    """One row; the step that the solver chose is asked for here, once, untimed."""
    report = _solve(build(scene, model.elements, model.measure), scene, model)

    def prepare() -> Run:
        built = build(scene, model.elements, model.measure)

        def run() -> Trajectory:
            _solve(built, scene, model)
            return sensor_trajectory(built, scene.main_point)

        return run

    return Case(
        label=label or _label(model, report),
        formulation="inextensible",
        integrator=model.settings.integrator,
        elements=model.elements,
        step_size=report["stepSize"],
        steps=report["steps"],
        prepare=prepare,
        details={
            "zeta": model.settings.stabilizationRate,
            "curvatureMeasure": model.measure,
            "massScaling": model.settings.massScaling,
            "stepDecidedBy": report["decidedBy"],
            "stepLimit": report["bounds"].stability_limit,
            "ruleStep": report["bounds"].rule,
        },
    )


def fine_solution(scene: Scene, elements: int) -> Trajectory:
    """A run whose error is that of the mesh: a fifth of the default step."""
    settings = ExplicitSettings(stepConstant=0.14)
    model = build(scene, elements)
    _solve(model, scene, Inextensible(elements, settings))
    return sensor_trajectory(model, scene.main_point)


def _label(model: Inextensible, report: dict[str, Any]) -> str:
    parts = [f"inextensible {model.settings.integrator}, N = {model.elements}"]
    parts.append(f"h = {report['stepSize']:.3g} s")
    if model.settings.stabilizationRate != ExplicitSettings.stabilizationRate:
        parts.append(f"zeta = {model.settings.stabilizationRate:g} 1/s")
    if model.settings.massScaling:
        parts.append(f"mass scaling {model.settings.massScaling:g}")
    if model.measure != "secondDerivative":
        parts.append(model.measure)
    return ", ".join(parts)


def _solve(model: Model, scene: Scene, inextensible: Inextensible) -> dict[str, Any]:
    period = inextensible.output_period or SENSOR_PERIOD
    settings = quiet_settings(scene.end_time, round(scene.end_time / period), period)
    with silence():
        return SolveExplicit(model.mbs, settings, inextensible.settings)
