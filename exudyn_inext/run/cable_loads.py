"""The external force of one cable: gravity, constant forces, and sampled histories; and its motions."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.link import Motion
from ..cable.links import all_links, motions_of
from ..constraints.motion import jump_of_velocity
from ..errors import SceneError
from ..integrators.integrator import LoadHistory
from ..loads.nodal import ConstantForces, NodalLoad, out_of_plane
from ..loads.weight import ConstantWeights, ElementWeight
from ..scene.model import CableInScene, CableLoad
from .jump_ahead import SMALL, JumpSight
from .load_functions import Asked, LoadFunctions
from .ramp import NO_STEP, Ramp
from .settings import SAY_OF_TIME
from .step_control import Piece


def _at_rest(motion: Motion, dim: int) -> Array:
    """(3 dim,) p, p_t, p_tt of a motion that rests; zero for one that does not."""
    return motion.at(0.0).ravel() if motion.rests else np.zeros(3 * dim)


class CableLoads:
    """External force of a cable, and motions of its links' anchors behind it, as functions of time.

    constant: (n_external,) [N, Nm].   pattern: (P, n_external), one row a component of a load history or
    a motion; if loads may `ramp`, the last one is what is missing of the constant at the start of a step.
    follows: whether they may.
    """

    def __init__(self, cable: CableInScene, follows: bool = False) -> None:
        self._dimension = cable.cable.dimension
        self._item, self._name = cable.item, cable.name
        motions = motions_of(all_links(cable.cable))
        steady = [load for load in cable.loads if load.history is None]
        weights = [load for load in steady if isinstance(load, ElementWeight)]
        self._weights = ConstantWeights(cable.cable, cable.item.gravity, weights)
        on_nodes = [load for load in steady if isinstance(load, NodalLoad)]
        self._forces = ConstantForces(cable.cable, cable.item.nodes, on_nodes)
        force = self._constant_force
        self.constant = np.concatenate([force, *(_at_rest(motion, self._dimension) for motion in motions)])
        self._motions = [motion for motion in motions if not motion.rests]
        self._names = [_name_of(motion, cable) for motion in self._motions]
        self._histories = [load for load in cable.loads if load.history is not None]
        self._functions = LoadFunctions([_asked(load) for load in self._histories])
        self._out_of_plane = self._columns_out_of_plane(self._histories)
        rows = [row for load in self._histories for row in self._patterns(load)]
        self.sight = JumpSight(self._columns_of_places(len(rows)), SMALL * cable.cable.length, self.factors)
        if self._motions:
            rows += self._motion_patterns(len(force), motions)
        self._ramp = Ramp() if follows else None
        rows += [np.zeros_like(self.constant)] * follows
        self.pattern = np.array(rows).reshape(len(rows), len(self.constant))
        self._time, self._varying = np.nan, self.constant  # what varies, at the time that was asked for last

    @property
    def _constant_force(self) -> Array:
        """(n_dof,) without motions."""
        return self._weights.force + self._forces.force

    def change(self, values: Mapping[int, Sequence[float]]) -> set[int]:
        """Give constant loads other components; returns which of them act on this cable.

        values: (m,) as they are set [N, Nm; of a weight m/s^2], by numbers of loads in the mbs.
        """
        found = self._weights.change(values) | self._forces.change(values)
        if found:
            force = self._constant_force
            self.constant[: len(force)] = force
        return found

    def ramp(self, values: Mapping[int, Sequence[float]], time: float, end: float) -> set[int]:
        """As `change`, along a line from `time` to `end` [s]."""
        assert self._ramp
        before = self.constant.copy()
        found = self.change(values)
        np.subtract(before, self.constant, out=self.pattern[-1])
        self._ramp.begin(time, end)
        self._time = np.nan
        return found

    def missing(self, time: float) -> float:
        """Share of its change that a `ramp` lacks at `time` [s]."""
        return self._ramp.share(time) if self._ramp else 0.0

    @property
    def kept_ramp(self) -> dict[str, list[Any]]:
        """See `CableRun.ramp`."""
        return {"step": self._ramp.step, "missing": self.pattern[-1].tolist()} if self._ramp else {}

    def take_ramp(self, kept: Mapping[str, Any]) -> None:
        """See `CableRun.take_ramp`."""
        if self._ramp:
            self._ramp.begin(*kept.get("step", NO_STEP))
            self.pattern[-1] = kept.get("missing", 0.0)

    @property
    def follows(self) -> bool:
        """Whether loads may change along a line within a step."""
        return self._ramp is not None

    @property
    def varies(self) -> bool:
        """Whether forces or motions depend on the time by themselves."""
        return bool(self._histories or self._motions)

    @property
    def has_histories(self) -> bool:
        """Whether forces depend on the time."""
        return bool(self._histories)

    def gravity_at(self, time: float) -> Array:
        """(N, dim) gravity acceleration of each element at `time` [m/s^2]."""
        total = self._weights.gravity
        for load in self._histories:
            if isinstance(load, ElementWeight):
                total = total + load.gravity(self._components_at(load, time), total.shape)
        return total

    def has_functions_of(self, other: "CableLoads") -> bool:
        """Whether the same user functions are given the same values, and act as in other loads."""
        own, others = (
            [(id(load.history and load.history.function), load.constant.tolist()) for load in one._histories]
            for one in (self, other)
        )
        return own == others and self.has_pattern_of(other)

    def has_pattern_of(self, other: "CableLoads") -> bool:
        """Whether the same histories and motions act as in other loads."""
        own, others = (one.pattern[: len(one.pattern) - one.follows] for one in (self, other))
        return np.array_equal(own, others)

    def take_constants(self, other: "CableLoads") -> None:
        """Have the values of other loads, which have the same functions; see `has_functions_of`."""
        self._weights, self._forces = other._weights, other._forces
        self.constant[:] = other.constant

    @property
    def known_ahead(self) -> bool:
        """Whether nothing but the time decides on loads and motions."""
        return all(load.is_pure for load in self._histories) and all(m.is_pure for m in self._motions)

    @property
    def are_steady(self) -> bool:
        """Whether nothing depends on the time, as long as nothing is moved that is set between steps."""
        return not self._histories and not any(motion.is_pure for motion in self._motions)

    @property
    def not_compiled(self) -> str:
        """Among bodies: which weight or motion only Exudyn's side evaluates; empty if none."""
        for load in sorted(self._histories, key=lambda load: load.is_pure):
            whose = "of time" if load.is_pure else "that may depend on the state"
            remedy = "" if load.is_pure else f" (if it does not: {SAY_OF_TIME})"
            return f"the load on {load.place}, with a user function {whose}{remedy}"
        return "" if self.known_ahead else "supports of cables that were changed"

    def at(self, time: float) -> Array:
        """(n_external,) external force and motions at `time`; not to be written to."""
        if not len(self.pattern):
            return self.constant
        if time != self._time or not self.known_ahead:
            self._varying = self.factors([time])[0].dot(self.pattern)
            self._time = time
        return self.constant + self._varying

    def at_times(self, times: list[float]) -> Array:
        """(k, n_external) as `at`, at all of them."""
        if not len(self.pattern):
            return self.constant[np.newaxis].repeat(len(times), axis=0)
        return self.constant + self.factors(times) @ self.pattern

    def sample(self, piece: Piece, stages: Sequence[float]) -> LoadHistory:
        """Load history of a piece, at the stages of a scheme.

        Raises:
            JumpError: a support jumps in it.
        """
        shape = (piece.steps, len(stages), len(self.pattern))
        if not (self.varies or (self._ramp and piece.time() < self._ramp.end)):
            return LoadHistory(self.constant, self.pattern, np.zeros(shape))
        times = piece.times(stages).ravel().tolist()
        factors = np.array(self.sight.look(piece.time(), times), order="C")  # of one type
        return LoadHistory(self.constant, self.pattern, factors.reshape(shape))

    def factors(self, times: list[float]) -> Array:
        """(T, P) of all load histories and motions."""
        columns = [self._of_motion(motion, times) for motion in self._motions]
        if self._histories or not (self._motions or self._ramp):
            columns.insert(0, self._functions.values(times))
            _require_none(self._out_of_plane, columns[0])
        if self._ramp:
            columns.append(self._ramp.missing(times)[:, np.newaxis])
        return np.concatenate(columns, axis=1) if len(columns) > 1 else columns[0]

    def _columns_of_places(self, first: int) -> tuple[list[int], list[int]]:
        """Of the factors, which are places and which velocities.   first: column of the motions.

        What step functions move, goes along lines; see `Steered`.
        """
        dim, number = self._dimension, len(self._motions)
        starts = range(first, first + 3 * dim * number, 3 * dim)
        smooth = [start for start, motion in zip(starts, self._motions, strict=True) if motion.is_smooth]
        places = [start + axis for start in smooth for axis in range(dim)]
        return places, [place + dim for place in places]

    def _of_motion(self, motion: Motion, times: list[float]) -> Array:
        """(T, 3 dim) p, p_t, p_tt.   SceneError if they are not finite."""
        values: Array = motion.sample(times).reshape(len(times), -1)
        if not math.isfinite(np.add.reduce(values, axis=None)) and not np.isfinite(values).all():
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            raise SceneError(
                f"a motion prescribed to a node of {self._name} has place, velocity and acceleration "
                f"{values[bad[0]].tolist()} at t = {times[bad[0]]:g} s: its functions must return finite "
                "numbers during the run."
            )
        return values

    def jump_of_velocity(self, time: float) -> float:
        """Of supports near `time` [s] [m/s]; or 0."""
        return max((jump_of_velocity(motion, time) for motion in self._motions), default=0.0)

    def places(self, time: float) -> Array:
        """(k,) coordinates of all motions at `time` [s] [m]."""
        return np.concatenate([np.zeros(0), *(motion.place(time) for motion in self._motions)])

    @property
    def names_of_places(self) -> list[str]:
        """(k,) whose they are, for messages."""
        return [name for name in self._names for _ in range(self._dimension)]

    def _components_at(self, load: CableLoad, time: float) -> Array:
        """(m,) components of a load with a history."""
        values = LoadFunctions([_asked(load)]).values([time])
        _require_none(self._columns_out_of_plane([load]), values)
        return values[0]

    def _columns_out_of_plane(self, loads: Sequence[CableLoad]) -> list[tuple[int, CableLoad]]:
        """Which of all components of these loads leave the cable's plane; and whose they are."""
        components = [(load, k) for load in loads for k in range(len(load.constant))]
        dim = self._dimension
        return [(place, load) for place, (load, k) in enumerate(components) if not load.is_in_space(k, dim)]

    def _motion_patterns(self, n_dof: int, motions: list[Motion]) -> list[Array]:
        """One unit row a component of p, p_t, p_tt of each motion."""
        width = 3 * self._dimension
        starts = [n_dof + k * width for k, motion in enumerate(motions) if not motion.rests]
        places = [place for start in starts for place in range(start, start + width)]
        rows = np.zeros((len(places), len(self.constant)))
        rows[np.arange(len(places)), places] = 1.0
        return list(rows)

    def _patterns(self, load: CableLoad) -> Array:
        """(m, n_external) one unit force a component; zero for one that is out of the cable's plane."""
        forces = load.unit_forces(self._item.cable, self._item.nodes)
        patterns = np.zeros((len(forces), len(self.constant)))
        patterns[:, : forces.shape[1]] = forces
        return patterns


def _name_of(motion: Motion, cable: CableInScene) -> str:
    """Which constraint of a cable follows it."""
    link = next(link for link in all_links(cable.cable) if link.anchor is motion)
    names = " and ".join(str(cable.item.node_names[k]) for k in link.nodes)
    return f"the {link.kind} constraint at node {names} of cable '{cable.name}'"


def _asked(load: CableLoad) -> Asked:
    """A load that has a user function."""
    assert load.history is not None
    return Asked(load.history, len(load.constant), f"the load on {load.place}", load.is_pure)


def _require_none(columns: Sequence[tuple[int, CableLoad]], values: Array) -> None:
    """SceneError if there is a force out of a cable's plane.   values: (T, m) of all components."""
    for place, load in columns:
        column = values[:, place]
        if column.any():
            raise out_of_plane(load, column[np.flatnonzero(column)[0]])
