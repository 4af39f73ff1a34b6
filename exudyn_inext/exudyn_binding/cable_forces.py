"""Tension, shear force and bending moment of a cable of an mbs, as values and sensors, and its energies."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from numbers import Integral
from typing import Any

import numpy as np
from exudyn.itemInterface import SensorUserFunction

from ..arrays import Array
from ..cable.axial_energy import strain_tension
from ..cable.axial_stiffness import set_step_of_means
from ..cable.cable import Cable
from ..cable.frequency import nodal_multipliers_of
from ..cable.linked_cable import cable_system
from ..cable.section_forces import (
    SectionForces,
    SectionPoints,
    SolvedState,
    multiplier_tension,
    section_forces,
)
from ..cable.support_forces import Solved, SupportedCable, solved_state
from ..called_system import Bound
from ..checks import LARGEST_NUMBER_OF_ITEMS, require_flag, require_integer
from ..errors import InputError, SceneError
from ..items.arguments import described
from ..items.cable_data import point_on_cable, require_cable
from ..native.coupled_scene import CoupledScene
from ..native.evaluated_scene import CoupledCable
from ..native.native_items import state_kept, switched_off
from ..native.velocity_level import at_position_level
from ..run.cable_loads import CableLoads
from ..scene.model import CableInScene, Scene
from ..system import ELASTIC, KINETIC, REPORTED, report_energy
from .mbs_state import last_step
from .scene import read_scene, require_assembled

OfRun = Callable[[int, float], Solved | None]  # see `ExplicitTimeLoop.solved`


def _nothing_known(cable: int, time: float) -> None:
    """Without a run."""


class SceneEvaluator:
    """Evaluates an mbs at its present state, apart from any running solver.

    It holds no mbs, so that a sensor which keeps it does not keep its mbs alive, until it has had to evaluate
    a cable among bodies and joints; see `forget_evaluators`.
    """

    def __init__(self, mbs: Any) -> None:
        require_assembled(mbs)
        self.scene = read_scene(mbs)
        self._loads: dict[int, CableLoads] = {}
        self._values: dict[int, Sequence[float]] = {}  # of loads that have been set since
        self._alone: dict[int, SupportedCable] = {}
        self._coupled: CoupledScene | None = None
        self._solved: bytes | None = None  # the state of all parts that has been evaluated last

    def loads(self, place: int) -> CableLoads:
        """On a cable, by its place in the scene."""
        if place not in self._loads:
            self._loads[place] = CableLoads(self.scene.cables[place])
            self._loads[place].change(self._values)
        return self._loads[place]

    def take_forces(self, values: Mapping[int, Sequence[float]]) -> None:
        """Loads on cables among nothing else have other values, or what is no cable has other forces.

        values: see `CableLoads.change`.
        """
        self._values |= values
        for loads in self._loads.values():
            loads.change(values)
        self._solved = None

    def solve(self, mbs: Any, place: int) -> Solved:
        """A cable in the present state."""
        return self._solve_among_others(mbs, place) if self.scene.foreign else self._solve_alone(mbs, place)

    def _last_step(self, mbs: Any, place: int) -> float:
        """Before the present state, of a cable [s]."""
        return last_step(mbs.sys, self.scene.cables[place].number, mbs.systemData.GetTime())

    def _solve_alone(self, mbs: Any, place: int) -> Solved:
        data, cable = mbs.systemData, self.scene.cables[place]
        if place not in self._alone:
            self._alone[place] = SupportedCable(cable.cable)
        q = cable.cable.reference.ravel() + np.asarray(data.GetODE2Coordinates())[cable.indices]
        v = np.asarray(data.GetODE2Coordinates_t())[cable.indices]
        given = self.loads(place).at(data.GetTime()), q, v, self._last_step(mbs, place)
        return self._alone[place].solved(*given)

    def _solve_among_others(self, mbs: Any, place: int) -> Solved:
        """With all bodies and joints, evaluated by Exudyn; its state is put back."""
        self._coupled = coupled = self._coupled or self._coupled_scene(mbs)
        time, (q, v) = mbs.systemData.GetTime(), coupled.state()
        steps = [self._last_step(mbs, k) for k in range(len(self.scene.cables))]
        state = np.concatenate([[time, *steps], q, v]).tobytes()
        if state != self._solved:
            for step, system in zip(steps, coupled.cable_systems, strict=True):
                if system.chain.elements["axial"].size:
                    set_step_of_means(step, system.chain.nodes, system.chain.elements)
            with switched_off(mbs, *self.scene.evaluated_by_kernels), state_kept(mbs):
                coupled.native_items.forget()
                coupled.solve(time, q, v)
            self._solved = state
        dofs, system = coupled.map.slices[place], coupled.cable_systems[place]
        a = coupled.set_multipliers(place, time, q, v)
        return system, solved_state(system, q[dofs], v[dofs], a)

    def _coupled_scene(self, mbs: Any) -> CoupledScene:
        with switched_off(mbs, *self.scene.evaluated_by_kernels), state_kept(mbs):
            cables = [
                CoupledCable(
                    cable.among_others, cable_system(cable.cable, 0.0), CableLoads(cable.among_others)
                )
                for cable in self.scene.cables
            ]
            return CoupledScene(mbs, cables, self.scene.own_constraints, 0.0)


class CableEvaluator:
    """Evaluates one cable of a scene.   scene: what evaluates all of it.

    known: of the present state, by a run.
    """

    known: Solved | None = None

    def __init__(self, mbs: Any, number: int, scene: SceneEvaluator) -> None:
        self._scene, self._place = scene, _place_of(scene.scene, number)
        self._cable = scene.scene.cables[self._place]
        _require_linear_laws(mbs, self._cable)
        self._gravity = np.zeros(self._cable.cable.dimension)  # of the state that was solved
        self._points: dict[bytes, SectionPoints] = {}  # that have been asked for

    def forces(self, state: SolvedState, arc_length: Array) -> SectionForces:
        """Section forces at arc lengths (m,) [m]."""
        cable, key = self._cable.cable, arc_length.tobytes()
        if key not in self._points:
            self._points[key] = SectionPoints(cable, arc_length)
        density = cable.section.mass_per_length * self._gravity
        return section_forces(self._points[key], self._system.chain, state, density)

    def multiplier_tension(self, state: SolvedState) -> Array:
        """(N,) mean tension of the elements, from the multipliers [N]; once for each `solve`."""
        if self._cable.cable.stretches:
            return strain_tension(self._cable.cable, self._system.chain)
        nodal = nodal_multipliers_of(self._system, state.a)
        return multiplier_tension(self._cable.cable, state.q, state.v, nodal, state.multiplier)

    def energies(self, mbs: Any) -> tuple[float, float]:
        """Kinetic and elastic energy [J] of the present state; zero where nothing is strained."""
        system, state = self._solved(mbs)
        external = self._scene.loads(self._place).at(mbs.systemData.GetTime())
        q, v, a = (x.ravel() for x in (state.q, state.v, state.a))
        energies = np.zeros(REPORTED)
        Bound(report_energy, system)(external, q, v, a, np.zeros(q.size), energies)
        return float(energies[KINETIC]), float(energies[ELASTIC]) + self._cable.cable.natural_energy()

    def solve(self, mbs: Any) -> SolvedState:
        """The present state of the mbs, with its accelerations and multipliers."""
        self._gravity = self._scene.loads(self._place).gravity_at(mbs.systemData.GetTime())
        self._system, state = self._solved(mbs)
        return state

    def _solved(self, mbs: Any) -> Solved:
        return self.known or self._scene.solve(mbs, self._place)


class _Keeper:
    """What sensors of section forces keep from one output to the next; those of a run share one."""

    def __init__(self, of_run: OfRun = _nothing_known) -> None:
        self._of_run = of_run
        self.forget()

    def forget(self) -> None:
        self._scene: SceneEvaluator | None = None
        self._time = np.inf
        self._cables: dict[int, CableEvaluator] = {}
        self._asked: set[Any] = set()

    def take_forces(self, values: Mapping[int, Sequence[float]]) -> None:
        """Arguments: see `SceneEvaluator.take_forces`."""
        if self._scene:
            self._scene.take_forces(values)

    def evaluator(self, mbs: Any, number: int, time: float, who: Any) -> CableEvaluator:
        """Of a cable; read again if the same sensor asks again: then loads may have changed, out of a run."""
        known = self._of_run(number, time)
        may_have_changed = time == self._time and who in self._asked and known is None
        if self._scene is None or time < self._time or may_have_changed:
            self.forget()
            self._scene = SceneEvaluator(mbs)
        elif time > self._time:
            self._asked.clear()
        self._time = time
        self._asked.add(who)
        if number not in self._cables:
            self._cables[number] = CableEvaluator(mbs, number, self._scene)
        self._cables[number].known = known
        return self._cables[number]


def CableForces(mbs: Any, cable: Any, arcLengths: Any = None) -> dict[str, Any]:
    """Section forces along a cable in the present state of mbs.

    The moment falls to nothing within some sqrt(EI / T) of a clamp, T the tension there. Of a clamped rope
    that falls, elements of half that length gave its peaks within 4 %, those of that length within some 10 %,
    and those 1.7 times as long were 40 % off, though the motion was right within 1 %.

    Args:
        mbs: assembled system.
        cable: what CreateInextensibleCable returned, or the number of its object.
        arcLengths: (m,) points along the cable [m], or a number of equidistant points; None: 10 for
            each element and the last end. At a node, values are those of the element before it.

    Returns:
        dict with arrays 'arcLength' (m,) [m], 'position' (m, dim) [m], 'tension' (m,) [N], 'shearForce'
        (m, dim) [N], 'bendingMoment' (m,) [N m] (with that of the bending damping, as in native cables;
        signed in the plane, its size in space), and 'multiplierTension' (N,) [N]: the mean over each
        element, from Lagrange multipliers and curvature.
        With axialStiffness it is that of EA times the strain, and what its rate adds; after steps of a
        run, all forces are those that acted in these, means of axial vibrations that they do not resolve.

    Raises:
        InputError: not a cable, or a point that is not on it.
        SceneError: mbs not assembled, or contains what is not supported.

    Example:
        forces = CableForces(mbs, cable, 101)
        plt.plot(forces["arcLength"], forces["tension"])
    """
    number, item = require_cable(mbs, cable)
    with at_position_level(mbs, mbs.systemData.GetTime()):
        evaluator = CableEvaluator(mbs, number, SceneEvaluator(mbs))
        points, state = _points(arcLengths, item.cable), evaluator.solve(mbs)
    forces = evaluator.forces(state, points)
    return {
        "arcLength": forces.arc_length,
        "position": forces.position,
        "tension": forces.tension,
        "shearForce": forces.shear_force,
        "bendingMoment": forces.bending_moment,
        "multiplierTension": evaluator.multiplier_tension(state),
    }


def CreateCableForceSensor(
    mbs: Any, cable: Any, arcLength: float, storeInternal: bool = True, fileName: str = ""
) -> int:
    """Sensor of tension [N] and bending moment [N m] at one point of a cable; at clamps see `CableForces`.

    Args:
        mbs: the system where the sensor is added.
        cable: what CreateInextensibleCable returned, or the number of its object.
        arcLength: where, 0 to the cable's length [m].
        storeInternal, fileName: as in native sensors; an empty name writes no file.

    Returns:
        sensor number; its values are [tension, bendingMoment].

    Raises:
        InputError: not a cable, or the point is not on it; mbs is unchanged then.
    """
    number, item = require_cable(mbs, cable)
    point = np.array([point_on_cable(arcLength, item.cable.length)])

    def tension_and_moment(evaluator, mbs):
        forces = evaluator.forces(evaluator.solve(mbs), point)
        return [float(forces.tension[0]), float(forces.bending_moment[0])]

    return add_sensor_of_cable(mbs, number, tension_and_moment, storeInternal, fileName)


def CreateCableEnergySensor(mbs: Any, cable: Any, storeInternal: bool = True, fileName: str = "") -> int:
    """Sensor of the kinetic and elastic energy of a cable [J].

    It takes the place of sensors of KineticEnergy and PotentialEnergy of native elements, summed over them.
    As there, the elastic energy is that of bending and stretch, without gravity. The kinetic one is with
    point masses on the cable.

    Args:
        mbs: the system where the sensor is added.
        cable: what CreateInextensibleCable returned, or the number of its object.
        storeInternal, fileName: as in native sensors; an empty name writes no file.

    Returns:
        sensor number; its values are [kinetic energy, elastic energy].

    Raises:
        InputError: not a cable; mbs is unchanged then.
    """
    number, _ = require_cable(mbs, cable)
    return add_sensor_of_cable(
        mbs, number, lambda evaluator, mbs: list(evaluator.energies(mbs)), storeInternal, fileName
    )


def add_sensor_of_cable(
    mbs: Any,
    number: int,
    values: Callable[[CableEvaluator, Any], list[float]],
    storeInternal: Any,
    fileName: Any,
) -> int:
    """A sensor of what `values(evaluator, mbs)` gives of a cable; returns its number.

    number: of the cable's object.   storeInternal, fileName: as in native sensors.

    Raises:
        InputError: storeInternal is no flag, or fileName no string; mbs is unchanged then.
    """
    is_stored = require_flag("storeInternal", storeInternal)
    if not isinstance(fileName, str):
        raise InputError(f"fileName = {fileName!r}: must be a string; an empty one writes no file.")

    def cable_user_function(mbs, t, sensorNumbers, factors, configuration):
        this = cable_user_function
        if this.is_asked:
            raise SceneError(
                f"a user function of a load or an object asks for forces of the cable of object {number}, "
                "which follow from what it returns: let a step function (mbs.SetPreStepUserFunction) read "
                "that sensor, and set the load or the object."
            )
        this.is_asked = True
        try:
            return values(this.keeper.evaluator(mbs, number, t, this), mbs)
        finally:
            this.is_asked = False

    cable_user_function.is_asked = False  # type: ignore[attr-defined]
    cable_user_function.onlyLooks = True  # type: ignore[attr-defined]
    cable_user_function.keeper = _Keeper()  # type: ignore[attr-defined]
    return int(
        mbs.AddSensor(
            SensorUserFunction(
                sensorUserFunction=cable_user_function,
                storeInternal=is_stored,
                fileName=fileName,
                writeToFile=bool(fileName),
            )
        )
    )


@contextmanager
def shared_evaluators(sensors: Sequence[Any], of_run: OfRun) -> Iterator[None]:
    """Sensors of section forces evaluate a state together; afterwards they have let go of what they keep.

    sensors: data of all.   of_run: what it knows.
    """
    shared, functions = _Keeper(of_run), _with_keepers(sensors)
    try:
        for function in functions:
            function.keeper = shared
        yield
    finally:
        for function in functions:
            function.keeper = _Keeper()


def forget_evaluators(sensors: Sequence[Any]) -> None:
    """Sensors of section forces let go of what they keep.   sensors: data of all."""
    for function in _with_keepers(sensors):
        function.keeper.forget()


def take_forces(sensors: Sequence[Any], values: Mapping[int, Sequence[float]]) -> None:
    """No more has been changed than forces: sensors of section forces keep what does not depend on them.

    sensors: data of all.   values: see `SceneEvaluator.take_forces`.
    """
    for function in _with_keepers(sensors):
        function.keeper.take_forces(values)


def _with_keepers(sensors: Sequence[Any]) -> list[Any]:
    """Functions of sensors of section forces."""
    functions = (
        data["sensorUserFunction"]["function"] for data in sensors if data["sensorType"] == "UserFunction"
    )
    return [function for function in functions if isinstance(getattr(function, "keeper", None), _Keeper)]


def _place_of(scene: Scene, number: int) -> int:
    """Which of the cables of the scene an object is."""
    for place, cable in enumerate(scene.cables):
        if cable.number == number:
            return place
    raise SceneError(
        f"object {number} is no cable of the assembled system: call mbs.Assemble(), and create sensors after "
        "items were deleted."
    )


def _require_linear_laws(mbs: Any, cable: CableInScene) -> None:
    """Raise SceneError if elements with user functions bend or pull the cable."""
    spans = set(pairwise(cable.item.node_names))
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        if data["objectType"] != "ANCFCable2D" or tuple(map(int, data["nodeNumbers"])) not in spans:
            continue
        if data["bendingMomentUserFunction"] or data["axialForceUserFunction"]:
            raise SceneError(
                f"{described(data, number)} bends or pulls cable '{cable.name}' by user functions, of which "
                "its section forces and energies know nothing: ask for CurvatureLocal or StrainLocal of that "
                "element by SensorBody, and call the functions with these."
            )


def _points(given: Any, cable: Cable) -> Array:
    if given is None:
        return np.linspace(0.0, cable.length, 10 * cable.number_of_elements + 1)
    if isinstance(given, Integral) and not isinstance(given, bool) and int(given) >= 2:
        number = require_integer("arcLengths", given, 2, LARGEST_NUMBER_OF_ITEMS)
        return np.linspace(0.0, cable.length, number)
    is_sequence = isinstance(given, Sequence | np.ndarray) and not isinstance(given, str | bytes)
    if not is_sequence or getattr(given, "shape", None) == () or not len(given):
        raise InputError(f"arcLengths = {given!r}: must be points (m,) [m], or how many, at least 2.")
    return np.array([point_on_cable(x, cable.length) for x in given])
