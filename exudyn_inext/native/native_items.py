"""Forces, masses and joints of an mbs for a coupled system, evaluated by Exudyn."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..compiled import kernel
from ..errors import DivergenceError
from ..items.cable_data import find_cable_item
from ..items.functions_of_time import is_of_time_alone
from ..items.parameters import set_unnoted
from ..run.cable_loads import CableLoads
from ..run.steered import Steered
from ..scene.coupled_system import Part
from ..scene.joints import JointBlock, JointTerms
from ..scene.path_work import follow, gather
from .bodies import BodyMasses
from .coordinates import CoordinateMap
from .held import HeldCoordinates
from .joint_rows import JointRows
from .ramped_parameters import RampedParameters

_CURRENT, _START_OF_STEP = exudyn.ConfigurationType.Current, exudyn.ConfigurationType.StartOfStep
_OF_FORCES = tuple(
    f"{which}UserFunction" for which in ("force", "springForce", "springTorque", "springForceTorque")
)
_OF_LOADS = "loadUserFunction", "loadVectorUserFunction"


class NativeItems:
    """What Exudyn knows of a scene: all forces by one call, joints, masses that change.

    joints: names of the rows.   blocks: their Jacobian by parts.
    native_forces: (n,) what Exudyn's items did to all second order coordinates when last asked [N, Nm].
    varying_forces: (n,) the same, with the weights of cables that change in time.
    given: (n,) forces on all parts that others have set.
    ramped: parameters that change along a line.
    approach: of joints (m,) that were changed before the present step of the time loop.
    path: memory of the work that they do from one evaluation to the next, see `build_path`; None: not now.
        Of several evaluations in a step, the first one is left out: RK4's second one lies beside it.
    settles: whether contact and friction update what they remember at each evaluation, before it.
    weighs: whether masses that depend on q are wanted.
    subtract_inertia: (q, v, forces): takes inertia forces of the bodies off the forces (n,), for whoever
        knows their masses; None: Exudyn is asked for these.
    """

    joints: Sequence[str]
    blocks: Sequence[JointBlock]
    path: Array | None = None
    settles: bool = False
    weighs: bool = True
    subtract_inertia: Callable[[Array, Array, Array], None] | None = None
    _is_first: bool = True  # evaluation of a step
    _counted: Array | None = None  # the path, if it counts the present evaluation

    def __init__(
        self,
        mbs: Any,
        solver: Any,
        wholes: Sequence[Part],
        coordinates: CoordinateMap,
        loads: Sequence[CableLoads],
        masses: BodyMasses,
        rows: JointRows,
        held: HeldCoordinates,
    ) -> None:
        self.joints = rows.names
        self.blocks = rows.blocks
        self.approach = Steered(len(rows.names))
        self._mbs = mbs
        self.ramped = RampedParameters(mbs)
        self._data = mbs.systemData
        self._solver = solver
        self._settings = exudyn.SimulationSettings()
        self._coordinates, self._number = coordinates, len(coordinates.indices)
        self._loads = loads
        self._cables = list(coordinates.slices[: len(loads)])
        self._dofs = [part.dofs for part in wholes]
        self._of_wholes = [_those_within(part.dofs, self._cables) for part in wholes]
        self.take_constants()
        self._masses = masses
        self._rows = rows
        self._held = held
        self._forces_on_held = np.zeros(len(held.rows))
        self._sizes = self._data.ODE2Size(), self._data.ODE1Size()
        self._bodies = coordinates.slices[len(loads)]
        self.remembers = bool(self._data.DataSize() or mbs.NumberOfGeneralContacts())
        self.native_forces = np.zeros(self._number)
        self.given = np.zeros(self._dofs[-1].stop)
        self._has_histories = any(of_cable.has_histories for of_cable in loads)
        self.varying_forces = self.native_forces.copy() if self._has_histories else self.native_forces
        self._positions = np.zeros(self._dofs[-1].stop)  # that mbs has at the time self._time
        self._values: Array | None = None  # of all joints, if they are known there
        self.forget()

    def forget(self) -> None:
        """Somebody else may have set the state of mbs."""
        self._time = np.nan

    def forces(self, t: float, q: Array, v: Array) -> Sequence[Array]:
        """Gravity and motions of the cables, and what `act` gives, on each whole."""
        total = self.act(t, q, v)
        if self._steady is not None:
            result = [force.copy() for force in self._steady]
        else:
            given = [loads.at(t) for loads in self._loads]
            if self._has_histories:
                self._add_histories(q, given)
            result = self._joined(given)
        for force, dofs in zip(result, self._dofs, strict=False):
            force[: dofs.stop - dofs.start] += total[dofs]
        result.append(total[self._bodies])
        if self._sizes[1]:
            result.append(total[self._bodies.stop :])
        return result

    def act(self, t: float, q: Array, v: Array) -> Array:
        """(n,) what Exudyn's items and others do to the parts, and rates of first order states.

        It sets masses that depend on q, unless nobody `weighs`.
        """
        self.set_state(t, q, v)
        if self.settles:
            self._settle()
        self._solver.ComputeODE2RHS(self._mbs)
        second, first = self._sizes
        if first:
            self._solver.ComputeODE1RHS(self._mbs)
        residual = self._solver.GetSystemResidual()
        if self._held.rows.size:
            self._forces_on_held[:] = residual[self._masses.held]
        forces = self.native_forces
        self._counted = None if self._is_first and not self.settles else self.path
        self._is_first = False
        gather(residual, self._coordinates.of_forces, forces)
        if self.subtract_inertia:
            self.subtract_inertia(q, v, forces)
        elif self.weighs:
            self._masses.update(q[self._bodies])
        if self._counted is not None and not self._has_histories:
            follow(self._counted, q, forces)
        if first:
            forces = np.concatenate([forces, residual[second : second + first]])
        return forces + self.given

    def rates_of_states(self, t: float, q: Array, v: Array) -> Array:
        """y' (k,) of the first order states, which are the last ones of v."""
        self.set_state(t, q, v)
        return self._present_rates()

    def _present_rates(self) -> Array:
        self._solver.ComputeODE1RHS(self._mbs)
        second, first = self._sizes
        return self._solver.GetSystemResidual()[second : second + first]

    def take_constants(self) -> None:
        """Constant loads on cables, which may have been changed."""
        is_steady = not any(len(of_cable.pattern) for of_cable in self._loads)
        self._steady = self._joined([of_cable.constant for of_cable in self._loads]) if is_steady else None

    def _joined(self, given: Sequence[Array]) -> list[Array]:
        """Copies for each whole: of one cable with its motions, of several, which have none, side by side.

        given: of each cable.
        """
        return [np.concatenate(given[which]) for which in self._of_wholes if which.stop > which.start]

    def _add_histories(self, q: Array, given: Sequence[Array]) -> None:
        """Set the forces that vary, and count their work.   given: of each cable's own loads, at present."""
        self.varying_forces[:] = self.native_forces
        for force, loads, dofs in zip(given, self._loads, self._cables, strict=True):
            self.varying_forces[dofs] += (force - loads.constant)[: dofs.stop - dofs.start]
        if self._counted is not None:
            follow(self._counted, q, self.varying_forces)

    def motions(self, t: float) -> Sequence[Array]:
        """Of the cables' own constraints; bodies and first order states have none."""
        nothing = np.zeros(0)
        alone = [which.start if which.stop - which.start == 1 else None for which in self._of_wholes]
        return [nothing if cable is None else self._loads[cable].at(t) for cable in alone]

    def approach_joints(self, t: float, end: float, q: Array, tolerance: float) -> None:
        """Let joints that are violated by more than the tolerance at (t, q) be fulfilled at `end` [s]."""
        self.forget()
        self._rows.forget()
        left = self._values_of_mbs(t, q)
        self.approach.aim(np.where(np.abs(left) > tolerance, left, 0.0), t, end)

    def violations(self, t: float, q: Array) -> Array:
        """c(q, t) (m,), of which an approach leaves a part."""
        values = self._values_of_mbs(t, q)
        return values - self.approach.left_at([t])[0, 0] if self.approach.moves else values

    def present_violations(self, t: float, q: Array) -> Array:
        """c(q, t) (m,) as it is now, after functions of the user may have changed it; mbs stays as it is."""
        self.forget()
        with self._visited(t, q):
            return self._values_of_mbs(t, q)

    def _values_of_mbs(self, t: float, q: Array) -> Array:
        """c(q, t) (m,) as Exudyn has it."""
        self._set_positions(t, q)
        if self._values is None:
            self._solver.ComputeAlgebraicEquations(self._mbs, False)
            equations = self._solver.GetSystemResidual()[sum(self._sizes) :]
            self._values = self._rows.values(self._mbs, equations)
        return self._values

    def constrain(self, t: float, q: Array, v: Array) -> JointTerms:
        """The joints at (t, q, v); their Jacobian goes to `blocks`."""
        self._set_positions(t, q)
        self._rows.update_jacobian(self._mbs, q)
        terms = self._rows.terms(self._mbs, self._values_of_mbs, t, q, v)
        if not self.approach.moves:
            return terms
        left, rate, acceleration = self.approach.left_at([t])[0]
        return JointTerms(terms.value - left, terms.drift - rate, terms.gamma + acceleration)

    def jacobian(self, t: float, q: Array) -> Sequence[JointBlock]:
        """Of the joints at (t, q), by parts, overwritten at the next evaluation."""
        self._set_positions(t, q)
        self._rows.update_jacobian(self._mbs, q)
        return self.blocks

    def finish_step(self, t: float, q: Array, v: Array) -> None:
        """The next step starts from what contact and friction remember at the end of this one.

        Where a step has one evaluation, at its end, they have settled there: a contact that closes within a
        step acts in it. Otherwise they do so here, as in Exudyn's explicit solvers, and act a step later.
        """
        self._is_first = True
        if not self.remembers:
            return
        if not self.settles or self.has_sliding_joints:  # joints have looked beside (q, v), too
            self.set_state(t, q, v)
        if not self.settles:
            self._settle()
        data = self.present_places()
        for configuration in (_CURRENT, _START_OF_STEP) if self._rows.sliding else (_START_OF_STEP,):
            self._data.SetDataCoordinates(data, configuration)

    def present_places(self) -> Array:
        """(D,) data of mbs with the places of what slides; OffCableError if one has left its cable."""
        return self._rows.put_places(self._mbs, self.remembered)

    @property
    def remembered(self) -> Array:
        """(D,) by contacts at present."""
        return np.array(self._data.GetDataCoordinates())

    @property
    def has_contact(self) -> bool:
        """Whether something may touch: contact, a GeneralContact, or the stops of a spring."""
        mbs = self._mbs
        remembering = range(mbs.systemData.NumberOfObjects() if self._data.DataSize() else 0)
        kinds = {mbs.GetObject(number)["objectType"] for number in remembering}
        return bool(mbs.NumberOfGeneralContacts()) or any("Contact" in k or k.endswith("Ext") for k in kinds)

    @property
    def may_touch(self) -> bool:
        """Whether something may be hit: contact, or what functions make of springs, objects and loads."""
        if self.has_contact:
            return True
        mbs, data = self._mbs, self._mbs.systemData
        objects = (mbs.GetObject(number) for number in range(data.NumberOfObjects()))
        loads = (mbs.GetLoad(number) for number in range(data.NumberOfLoads()))
        given = [item.get(key) for item in objects if not find_cable_item(item) for key in _OF_FORCES]
        of_loads = [item.get(key) for item in loads for key in _OF_LOADS]
        of_state = (one and not is_of_time_alone(mbs, one) for one in of_loads)
        return any(given) or any(of_state)

    @property
    def depths_of_contacts(self) -> Array | None:
        """(2, D) what they remember: signs, and of what is negative, as in closed contacts, powers of two.

        Zero for springs that count turns. None: nobody knows, as of a GeneralContact.
        """
        if self._mbs.NumberOfGeneralContacts():
            return None
        data = np.where(self._are_turns, 0.0, self.remembered)
        return np.array([np.sign(data), np.frexp(np.minimum(data, 0.0))[1]])

    @cached_property
    def _are_turns(self) -> np.ndarray:
        """(D,) whether data are angles of springs that count turns."""
        result, data = np.zeros(self._data.DataSize(), bool), self._data
        for number in range(data.NumberOfObjects()):
            if self._mbs.GetObject(number)["objectType"] == "ConnectorTorsionalSpringDamper":
                result[np.array(data.GetObjectLTGData(number), dtype=int)] = True
        return result

    def settled(self, t: float, q: Array, v: Array) -> Array:
        """(D,) what contacts remember once they have settled at (t, q, v)."""
        self.set_state(t, q, v)
        self._settle()
        return self.remembered

    def look(self, t: float, q: Array, v: Array) -> None:
        """Evaluate a state that has been set; a GeneralContact acts as it does there."""
        if self._mbs.NumberOfGeneralContacts():
            self.settled(t, q, v)
        self.forces(t, q, v)

    def evaluate(self) -> None:
        """Contact settles in the present state of mbs, and Exudyn evaluates all forces there."""
        self._settle()
        self._solver.ComputeODE2RHS(self._mbs)

    def _settle(self) -> None:
        """Contact and friction look at the state of mbs."""
        if self.remembers:
            self._solver.PostNewton(self._mbs, self._settings)

    def show(self, t: float, state: Any, multipliers: Array) -> None:
        """Leave the state at t in mbs, with the Lagrange multipliers of all algebraic equations."""
        self.set_state(t, state.q, state.v)
        if self._sizes[1]:
            self._data.SetODE1Coordinates_t(self._present_rates())
        self._data.SetAECoordinates(multipliers)

    def multipliers(self, rows: Array, t: float, q: Array) -> Array:
        """Of all algebraic equations, from those of the joints (m,) at (t, q)."""
        if not self._rows.sliding:
            return self._rows.multipliers(self._mbs, rows, self._data.AEsize())
        with self._visited(t, q):
            return self._rows.multipliers(self._mbs, rows, self._data.AEsize())

    @property
    def has_sliding_joints(self) -> bool:
        return len(self._rows.sliding) > 0

    @property
    def places(self) -> dict[str, Array]:
        """From which the feet of what slides are looked for, by the numbers of their joints."""
        return {str(joint.number): joint.last for _, joint in self._rows.sliding}

    def beyond(self) -> Array:
        """(m,) how far what slides is beyond the ends of its cable at present [m]."""
        return self._rows.beyond(self._mbs)

    def places_in(self, data: Array, times: Sequence[float], history: Array) -> Array:
        """Data (k, D) with the places of what slides in some states.   history: (k, 3, n).

        Raises:
            OffCableError: one has left its cable.
        """
        for row, t, q in zip(data, times, history[:, 0], strict=True):
            with self._visited(t, q):
                self._rows.put_places(self._mbs, row)
        return data

    @contextmanager
    def _visited(self, t: float, q: Array) -> Iterator[None]:
        """mbs is at (t, q), and afterwards where it was."""
        with state_kept(self._mbs):
            self._set_positions(t, q)
            yield
        self.forget()

    def all_multipliers(self, multipliers: Array, a: Array) -> Array:
        """Of all algebraic equations, for the state that was evaluated last.

        Args:
            multipliers: (m,) of the joints.   a: (n,) accelerations of all parts.
        """
        result = self._rows.multipliers(self._mbs, multipliers, self._data.AEsize())
        on_held = self._forces_on_held - self._rows.on_held @ multipliers
        result[self._held.rows] = self._held.reactions(on_held, a[self._bodies])
        return result

    def _set_positions(self, t: float, q: Array) -> None:
        same, finite = _compare(q, self._positions)
        if same and self._time == t:
            return
        if not finite:
            raise DivergenceError("the coordinates are not finite: reduce stepSize.")
        self._time, self._values = t, None
        self._positions[:] = q
        self._data.SetTime(t)
        self._data.SetODE2Coordinates(self._coordinates.displacements(q[: self._number]))

    def set_state(self, t: float, q: Array, v: Array) -> None:
        """Bring mbs to the state (q, v) at t [s]."""
        self.ramped.follow(t)
        self._set_positions(t, q)
        self._data.SetODE2Coordinates_t(self._coordinates.rates(v[: self._number]))
        if self._sizes[1]:
            self._data.SetODE1Coordinates(v[self._number :])


def _those_within(dofs: slice, cables: Sequence[slice]) -> slice:
    """Which of the cables lie in a whole, all by their coordinates."""
    inside = [k for k, own in enumerate(cables) if dofs.start <= own.start < own.stop <= dofs.stop]
    return slice(inside[0], inside[-1] + 1) if inside else slice(0, 0)


def evaluator(mbs: Any) -> Any:
    """A solver of Exudyn that evaluates right-hand sides; the current state of mbs stays as it is."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    solver: Any = exudyn.MainSolverImplicitSecondOrder()
    with state_kept(mbs):
        solver.InitializeSolver(mbs, settings)
    return solver


class DataCoordinates:
    """What contact and friction remember in an mbs, see `run.kept_state.KeptState`."""

    _CONFIGURATIONS = (_CURRENT, _START_OF_STEP)

    def __init__(self, data: Any) -> None:
        """data: mbs.systemData."""
        self._data = data

    def present(self) -> list[Any]:
        return [self._data.GetDataCoordinates(kind) for kind in self._CONFIGURATIONS]

    def put_back(self, copy: Sequence[Any]) -> None:
        for kind, values in zip(self._CONFIGURATIONS, copy, strict=True):
            self._data.SetDataCoordinates(values, kind)


@kernel
def _compare(x, y):
    """Whether x = y, and whether x is finite.   x, y: (n,)."""
    same, finite = True, True
    for i in range(len(x)):
        same = same and x[i] == y[i]
        finite = finite and abs(x[i]) < np.inf
    return same, finite


@contextmanager
def state_kept(mbs: Any) -> Iterator[None]:
    """The current state of mbs is afterwards what it was before, with its accelerations."""
    data, current = mbs.systemData, exudyn.ConfigurationType.Current
    state, time, accelerations = data.GetSystemState(current), data.GetTime(), data.GetODE2Coordinates_tt()
    try:
        yield
    finally:
        data.SetSystemState(state, current)
        data.SetODE2Coordinates_tt(accelerations, current)
        data.SetTime(time)


@contextmanager
def switched_off(mbs: Any, cables: Sequence[int], constraints: Sequence[int] = ()) -> Iterator[None]:
    """Exudyn evaluates no force, mass or constraint of these objects: their own kernels do.

    Args:
        mbs: the system.   cables: numbers of ObjectGenericODE2.   constraints: numbers of constraints.
    """
    nothing = {
        "forceUserFunction": 0,
        "massMatrixUserFunction": 0,
        "jacobianUserFunction": 0,
        "massMatrix": np.zeros((0, 0)),
        "stiffnessMatrix": np.zeros((0, 0)),
        "dampingMatrix": np.zeros((0, 0)),
        "forceVector": [],
    }
    objects = ((number, mbs.GetObject(number)) for number in cables)
    saved = [
        (number, name, data[name]) for number, data in objects for name in nothing if _is_set(data[name])
    ]
    active = [number for number in constraints if mbs.GetObjectParameter(number, "activeConnector")]
    try:
        for number, name, _ in saved:
            set_unnoted(mbs, number, name, nothing[name])
        for number in active:
            set_unnoted(mbs, number, "activeConnector", False)
        yield
    finally:
        for number, name, value in saved:
            set_unnoted(mbs, number, name, value["function"] if isinstance(value, dict) else value)
        for number in active:
            set_unnoted(mbs, number, "activeConnector", True)


def _is_set(value: Any) -> bool:
    return bool(value) if isinstance(value, dict | int) else np.size(value) > 0
