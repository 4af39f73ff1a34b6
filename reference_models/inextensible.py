"""A scene as an inextensible cable, moved by the plugin's explicit integrators."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import exudyn

from exudyn_inext import (
    CableForces,
    CableShape,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    SolveEquilibrium,
    SolveExplicit,
)
from exudyn_inext.checks import LARGEST_NUMBER_OF_ITEMS, require_integer
from exudyn_inext.errors import InputError

from .conventional.supports import add_constraint
from .loads import assembled
from .model import (
    SENSOR_PERIOD,
    Model,
    node_index,
    quiet_settings,
    sensor_trajectory,
    silence,
)
from .scenes import Clamp, Hanger, Line, Scene
from .trajectory import Case, Run, Trajectory

_CABLE = 0  # number of the cable's object


@dataclass(frozen=True)
class Inextensible:
    """What distinguishes one inextensible run from another.

    elements: N.   settings: of SolveExplicit.   output_period: between two steps of Exudyn's loop [s];
    None: the sensors' period.   measure: curvature measure.
    length_constraints: n_bar of Eq. (19), 0 (none) to N; None: one an element.
    spatial: whether a planar scene is built in space.
    enforcement: of the length; see CreateInextensibleCable.
    """

    elements: int
    settings: ExplicitSettings = field(default_factory=ExplicitSettings)
    output_period: float | None = None
    measure: str = "secondDerivative"
    length_constraints: int | None = None
    spatial: bool = False
    enforcement: str = "projection"


def build(scene: Scene, elements: int, measure: str = "secondDerivative") -> Model:
    """Build and assemble the scene with one inextensible cable of equal elements."""
    return build_variant(scene, Inextensible(elements, measure=measure))


def build_variant(scene: Scene, inextensible: Inextensible) -> Model:
    """As `build`, with everything that distinguishes one model from another."""
    elements = inextensible.elements
    require_integer("elements", elements, 1, LARGEST_NUMBER_OF_ITEMS)
    dimension = 2 if scene.is_planar and not inextensible.spatial else 3
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    section = scene.cable.section
    start, end = _ground_constraints(scene, dimension)
    cable = CreateInextensibleCable(
        mbs,
        beamTemplate=InextensibleCable(
            section.mass_per_length,
            section.bending_stiffness,
            curvatureMeasure=inextensible.measure,
            numberOfLengthConstraints=inextensible.length_constraints,
        ),
        gravity=scene.gravity,
        groundConstraintsStart=start,
        groundConstraintsEnd=end,
        shape=_shape(scene, elements),
        dimension=dimension,
        enforcement=inextensible.enforcement,
    )
    nodes = tuple(cable["nodes"])
    if scene.cable.shape.closed:
        nodes += nodes[:1]
    _add_hangers(mbs, scene, nodes, dimension)
    return assembled(scene, container, mbs, nodes, lambda model: SolveEquilibrium(model.mbs))


def equilibrium_forces(scene: Scene, elements: int, points: int) -> dict[str, Any]:
    """What CableForces finds in the equilibrium that the scene starts from, start loads included."""
    resting = replace(scene, loads=(*scene.loads, *scene.start_loads), start_loads=())
    return CableForces(build(resting, elements).mbs, _CABLE, points)


def _shape(scene: Scene, elements: int) -> CableShape:
    cable = scene.cable
    if isinstance(cable.shape, Line):
        end = [a + cable.length * d for a, d in zip(cable.shape.start, cable.shape.direction, strict=True)]
        return CableShape.Line(cable.shape.start, end, elements, velocityEnd=scene.end_velocity)
    positions, slopes = cable.nodes(elements)
    closed = cable.shape.closed
    if cable.stress_free == "shape" and not closed:
        raise InputError(
            f"scene '{scene.name}': an open cable that is stress free in a curved shape is not built; use "
            "stress_free='straight'."
        )
    last = len(positions) - 1 if closed else len(positions)
    return CableShape(
        positions[:last],
        slopes[:last],
        elementLengths=cable.length / elements,
        closed=closed,
        lengthReference="straight" if scene.starts_from_equilibrium else "shape",
    )


def _ground_constraints(scene: Scene, dimension: int) -> tuple[list[bool] | None, list[bool] | None]:
    """Flags of the first and the last node."""
    flags: dict[float, list[bool]] = {}
    for support in scene.supports:
        if isinstance(support, Hanger):
            continue
        if support.at not in (0.0, 1.0):
            raise InputError(f"{support}: pins and clamps are at the ends, at 0.0 or 1.0.")
        flags[support.at] = [True] * dimension + [isinstance(support, Clamp)] * dimension
    return flags.get(0.0), flags.get(1.0)


def _add_hangers(mbs: Any, scene: Scene, nodes: Sequence[int], dimension: int) -> None:
    for support in scene.supports:
        if isinstance(support, Hanger):
            node = nodes[node_index(support.at, len(nodes) - 1)]
            add_constraint(mbs, node, support, dimension)


def inextensible_case(scene: Scene, model: Inextensible, label: str = "") -> Case:
    """One row; the step that the solver chose is asked for here, once, untimed."""
    report = _solve(build_variant(scene, model), scene, model)
    h, theta = report["stepSize"], report["massScaling"]
    halved = replace(model.settings, stepSize=0.5 * h, massScaling=theta)

    def prepare() -> Run:
        built = build_variant(scene, model)

        def run() -> Trajectory:
            _solve(built, scene, model)
            return sensor_trajectory(built, scene.main_point)

        return run

    return Case(
        label=label or label_of(model, h),
        formulation="inextensible",
        integrator=model.settings.integratorName,
        elements=model.elements,
        step_size=h,
        steps=report["steps"],
        prepare=prepare,
        details={
            "zeta": model.settings.stabilizationRate,
            "curvatureMeasure": model.measure,
            "massScaling": theta,
            "stepDecidedBy": report["decidedBy"],
            "stepLimit": report["bounds"].stability_limit,
            "ruleStep": report["bounds"].rule,
        },
        halved=lambda: inextensible_case(scene, replace(model, settings=halved)),
    )


def solved(scene: Scene, inextensible: Inextensible) -> Model:
    """The scene, built and run to its end."""
    model = build_variant(scene, inextensible)
    _solve(model, scene, inextensible)
    return model


def fine_solution(scene: Scene, elements: int) -> Trajectory:
    """A run whose error is that of the mesh: a fifth of the default step."""
    settings = ExplicitSettings(stepConstant=0.14)
    return sensor_trajectory(solved(scene, Inextensible(elements, settings)), scene.main_point)


def label_of(model: Inextensible, step_size: float) -> str:
    """Says all that distinguishes one inextensible row from another.   step_size: the one used [s]."""
    parts = [f"inextensible {model.settings.integratorName}, N = {model.elements}"]
    parts.append(f"h = {step_size:.3g} s")
    if model.settings.stabilizationRate != ExplicitSettings.stabilizationRate:
        parts.append(f"zeta = {model.settings.stabilizationRate:g} 1/s")
    if model.settings.massScaling:
        parts.append(f"mass scaling {model.settings.massScaling:g}")
    if has_corrector(model.settings):
        parts.append("corrector")
    if model.measure != "secondDerivative":
        parts.append(model.measure)
    if model.length_constraints is not None:
        parts.append(f"n_bar = {model.length_constraints}")
    if model.spatial:
        parts.append("in space")
    return ", ".join(parts)


def has_corrector(settings: ExplicitSettings) -> bool:
    """Whether Zhai's method evaluates once more at the end of a step."""
    return bool(getattr(settings.method[1], "corrector", False))


def _solve(model: Model, scene: Scene, inextensible: Inextensible) -> dict[str, Any]:
    period = inextensible.output_period or SENSOR_PERIOD
    settings = quiet_settings(scene.end_time, round(scene.end_time / period), period)
    with silence():
        return SolveExplicit(model.mbs, settings, replace(inextensible.settings, dependsOnTimeOnly=True))
