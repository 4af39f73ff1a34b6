"""ExplicitStepper: an mbs with cables, step by step, for hardware in the loop and co-simulation."""

import math
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..checks import require_finite, require_integer, require_positive
from ..errors import InputError
from ..items.arguments import explicit_settings, node_number
from ..native.native_items import state_kept
from ..run.cable_run import Start
from ..run.coupled_run import CoupledRun
from ..run.divergence import divergence
from ..run.settings import ExplicitSettings
from ..run.step_choice import MOST_DURATION, choose_step, shorten_for_stretch, warn_of_damping
from ..run.stepped_run import SteppedRun
from ..run.time_grid import TimeGrid, steps_of_interval
from .console import compile_notice
from .mbs_state import LastSteps
from .scene_runs import compiled_runs

MOST_STEPS = 1_000_000_000  # in one call
_SHOWN = (exudyn.ConfigurationType.Current, exudyn.ConfigurationType.Visualization)


class ExplicitStepper:
    """Moves an mbs with inextensible cables by a given number of steps at a time.

    Everything is allocated here; `Step` is one compiled call for each cable, keeps no memory and
    gives the states of `SolveExplicit`, bit by bit. The mbs is left alone until `WriteToSystem`.
    Among bodies, springs, joints and loads, all of which must have compiled forms, it is a few calls for
    the whole scene.

    Without a stepSize, the step is that of a run of SolveExplicit over `duration` with outputs at each
    `interval`. Where the motion turns out to be too fast for it, each step becomes two of half the size: from
    the beginning, if the first call of `Step` is long enough to find it, or else from then on. Forces to come
    may let cables that stretch vibrate along their axes: their steps are shorter than in a run, and `Start`
    tries the first ones.

    Args:
        mbs: assembled system; its cables start from the initial configuration.
        explicitSettings: as for SolveExplicit.
        stepSize: upper bound of the step [s]; replaces that of explicitSettings. None in both: chosen by
            accuracy, as by SolveExplicit.
        startTime: [s].
        interval: that `Step` moves on by [s], in equal steps. None: one step. With adaptiveStep, each call of
            `Step` takes as many steps as the present largest frequency asks for.
        duration: how long the motion will be, as far as it is known [s]: the longer, the smaller must be the
            error of each step that is chosen by accuracy.

    Attributes:
        stepSize: at the beginning [s].   massScaling: theta.   decidedBy: what bounded the step.
        bounds: StepSizeBounds.   interval: that `Step` moves on by [s].
        startCorrections: of each cable: how far its initial state was from its constraints.

    Raises:
        SceneError: mbs not assembled, without a cable, with items that only Exudyn can evaluate, or
            with pre- or post-step user functions.
        StepSizeError: the step is above the stability limit.
        RedundantConstraintError: constraints that depend on each other.

    Example:
        stepper = ExplicitStepper(mbs, stepSize=1e-3)
        stepper.Start()
        while running:
            stepper.SetNodeForce(node, measuredForce)
            stepper.Step()
            q, v, time = stepper.State()
    """

    @compile_notice()
    def __init__(
        self,
        mbs: Any,
        explicitSettings: ExplicitSettings | None = None,
        stepSize: float | None = None,
        startTime: float = 0.0,
        interval: float | None = None,
        duration: float = MOST_DURATION,
    ) -> None:
        explicit = explicit_settings(explicitSettings)
        if stepSize is not None:
            explicit = replace(explicit, stepSize=stepSize)
        start = require_finite("startTime", startTime, "s")
        interval = None if interval is None else require_positive("interval", interval)
        duration = require_positive("duration", duration)
        given = steps_of_interval(interval, explicit.stepSize, MOST_STEPS)[1] if explicit.stepSize else 0.0
        where = "between the steps of a stepper"
        runs = compiled_runs(mbs, start, given, explicit, "ExplicitStepper", where)
        scaling, longest = given if explicit.massScaling else 0.0, interval or math.inf
        choice = choose_step(runs, start, duration, explicit, scaling, longest=longest)
        choice = shorten_for_stretch(runs, choice)
        warn_of_damping(choice, duration)
        self.bounds, self.massScaling = choice.bounds, choice.theta
        self._substeps, self.stepSize = steps_of_interval(interval, choice.h, MOST_STEPS)
        self.decidedBy = choice.decider(self._substeps, self.stepSize, "interval")
        self.interval = self._substeps * self.stepSize
        self.startCorrections = [run.start_correction for run in runs]
        self._mbs, self._explicit = mbs, choice.explicit
        self._initial = self._initial_state()
        self._start_time, self._duration = start, duration
        self._runs, self._last_steps = [SteppedRun(run) for run in runs], LastSteps(mbs.sys, runs)
        self._cables = [cable for run in self._runs for cable in run.cables]
        self._run_of_node = {node: run for run in self._runs for node in run.nodes}
        self._taken = 0  # steps
        self._error: Exception = InputError("the stepper has not been started: call Start() before Step().")
        self._is_ready = False

    @property
    def time(self) -> float:
        """Of the present state [s]."""
        return self._start_time + self._taken * self.stepSize

    def Start(self) -> None:
        """Begin, or begin anew, from the initial configuration as it is now, with the forces that are set.

        Parameters of the mbs are those that it had when the stepper was made.

        Raises:
            SceneError: the initial configuration has been changed and violates constraints.
            RedundantConstraintError: constraints that depend on each other.
        """
        self._taken = 0
        self._is_ready = False
        initial = self._initial_state()
        is_same = all(map(np.array_equal, initial, self._initial))
        grid = TimeGrid(self._start_time, 1, self._substeps, self.stepSize)
        with compile_notice(), state_kept(self._mbs):
            for run in self._runs:
                run.start(self._start_time, self.stepSize)
                if not is_same:
                    run.start_from(*initial, Start(self._start_time, self.stepSize, self._explicit))
                run.run.rehearse_start(grid, self._duration)
        self._is_ready = True

    def _initial_state(self) -> tuple[Array, Array, Array]:
        """Displacements, velocities and data coordinates of the mbs."""
        data, initial = self._mbs.systemData, exudyn.ConfigurationType.Initial
        q, v = data.GetODE2Coordinates(initial), data.GetODE2Coordinates_t(initial)
        return np.array(q), np.array(v), np.array(data.GetDataCoordinates(initial))

    def Step(self, n: int = 1) -> None:
        """Move on by n intervals, or by n steps where no interval was given.

        User functions of loads and moving supports are called for all steps ahead, with the mbs as
        it is; they may allocate memory, the rest does not.

        Raises:
            InputError: n is not a positive integer, or `Start` has not been called.
            DivergenceError: the state left what a cable can do. `State` is the one before this call;
                the stepper has to be started anew.
        """
        if not self._is_ready:
            raise self._error
        most = MOST_STEPS // self._substeps
        steps = require_integer("n", n, 1, most, ", the steps of one call") * self._substeps
        grid = TimeGrid(self._start_time, 1, steps, self.stepSize, before=self._taken)
        with nullcontext() if self._taken else compile_notice():
            are_good = [run.step(grid) for run in self._runs]
        if not all(are_good):
            self._stop(grid.time(1))
        self._taken += steps

    def _stop(self, end: float) -> None:
        """Back to the last good state of all cables, in a call that should have got to `end` [s]; raises."""
        verdicts = [run.run.verdict(self.time, self.stepSize) for run in self._runs]
        for run in self._runs:
            run.restore()
        self._is_ready = False
        self._error = divergence(
            list(filter(None, verdicts)),
            end,
            f"The stepper holds the state at t = {self.time:.6g} s; Start() begins anew.",
        )
        raise self._error

    def State(self, cable: int = 0) -> tuple[Array, Array, float]:
        """Present state of a cable: q, v, time.

        q and v are views of the stepper's memory: cheap, always the present state, and not to be
        written to. Take copies of what shall last.

        Args:
            cable: which one, in the order of their creation.

        Returns:
            q: (n, 2, dim) total positions [m] and slopes [-] of the nodes along the cable; the last
                node of a closed one is the first once more.
            v: (n, 2, dim) their velocities [m/s, 1/s].
            time: [s].

        Raises:
            InputError: there is no such cable.
        """
        number = len(self._cables)
        q, v = self._cables[require_integer("cable", cable, -number, number - 1, ", counted from 0")]
        return q, v, self.time

    def SetNodeForce(self, node: int, force: Sequence[float]) -> None:
        """Set the force [N] on a node, besides gravity and the loads of the mbs, until it is set again.

        It is the force at the end of the next step; within a step, a scheme of order 2 sees it change
        linearly from that at its start. Forces that follow the time are thus integrated with the order
        of the scheme.

        Args:
            node: node number, of a cable or a body.   force: (3,) components; z must be zero for one that
                moves in the plane.

        Raises:
            InputError: not such a node, or not a force that it can take.
        """
        number = node_number(node)
        run = self._run_of_node.get(number)
        if run is None:
            others = " or body" if isinstance(self._runs[0].run, CoupledRun) else ""
            raise InputError(
                f"node = {node!r} is on no inextensible cable{others}: their nodes lie between "
                f"{min(self._run_of_node)} and {max(self._run_of_node)}."
            )
        run.set_force(number, force)

    def WriteToSystem(self) -> None:
        """Write the state, forces of joints and supports, and the time to the current state of the mbs.

        Sensors, outputs of nodes and objects and, after mbs.SendRedrawSignal(), the renderer then show it.
        """
        data = self._mbs.systemData
        states, reactions = np.zeros((3, data.ODE2Size())), np.zeros(data.AEsize())
        for run in self._runs:
            run.write(self.time, states, reactions)
        displacements, velocities, accelerations = states.tolist()
        remembered = self._runs[0].run.data[0].tolist() or data.GetDataCoordinates()
        for configuration in _SHOWN:
            data.SetDataCoordinates(remembered, configuration)
            data.SetODE2Coordinates(displacements, configuration)
            data.SetODE2Coordinates_t(velocities, configuration)
            data.SetODE2Coordinates_tt(accelerations, configuration)
            data.SetAECoordinates(reactions.tolist(), configuration)
            data.SetTime(self.time, configuration)
        self._last_steps.keep(self.time, self.interval, 1)
