"""What bounds the steps of a coupled scene, and what is said of it."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..integrators.linear_stability import frequency_limit
from ..multibody.general_contacts import MOST_DRAG
from ..scene.open_contacts import OpenContacts
from ..scene.small_vibrations import (
    FastestRates,
    VibrationTracker,
    decay_of_states,
    fastest_rates,
    frequency_of_states,
    swings_of_states,
)
from ..system import accelerate_and_project
from .cable_run import CableRun
from .divergence import explanation, listed
from .jump_ahead import look_between
from .moved_by_exudyn import MovedByExudyn
from .moved_by_kernels import MovedByKernels
from .mover import together
from .paced_run import PacedRun
from .redundancy import PULLED, held_straight
from .step_control import MOST_PARTS, FrequencyFollower, Piece, StepControl, StepRule
from .watch import ENERGY, JUMP, LACK_OF_WORK, NOT_FINITE, SPRINGS, UNSTABLE

STEPS_BETWEEN_LOOKS = 128  # at the frequency, which costs as much as some 20 evaluations
FEWEST_BETWEEN_LOOKS, MOST_BETWEEN_LOOKS = 8, 32  # where outputs are as close as steps
TIGHTER = 1.25  # times the tension for which the limit is known: another look at it
SLOW_WAVES = 0.01  # tension over rho_A l^2, times h^2: its waves bound no step; at some 0.1 they do
STEPS_BETWEEN_TENSIONS = 32  # two looks at them, more at the beginning
LARGEST_SHARE, SHARE = 0.85, 0.7  # of the limit then: of steps that stay as they are, and of shorter ones
OF_TOO_LONG_STEPS = ENERGY, JUMP, NOT_FINITE, UNSTABLE, LACK_OF_WORK  # troubles that these may cause
DRAGGING_PARTS = 4  # of the nominal step, up to which all are smaller where friction sways a circle
SLOWED = 2.0  # times a step that damping bounds is what holds without it
SMALLEST_SHARE = 0.3  # of steps that became short for contacts, and may be longer again


def steps_until_look(steps: int, most: int = STEPS_BETWEEN_TENSIONS) -> int:
    """Until the next look at tensions: there is one after 1, 2, 4 ... steps, and then every `most` steps."""
    every = min(1 << max(steps.bit_length() - 1, 0), most)
    return every - steps % every


class LimitedRun(PacedRun):
    """See `CoupledRun`.

    mover: who takes the steps.   why_not: why Exudyn does; empty if it does not.
    frequency_of_states, swings_of_states: of first order, when the limit was looked at last: by velocities
        [rad/s], and by themselves, (2, n) [rad/s, 1/s].
    """

    mover: MovedByKernels | MovedByExudyn
    why_not: str
    indices: np.ndarray
    _scene: Any
    _runs: Sequence[CableRun]
    _why: str  # Exudyn may have to
    _time: float  # of the state whose rates are known [s]
    _fastest: Array  # (2, 2, n) found by searches so far, see `fastest_rates`: as it is, and in contact
    frequency_of_states = 0.0
    explicit_limits = 0.0, 0.0  # of the step, if springs were explicit, with and without their dashpots [s]
    swings_of_states = np.zeros((2, 0))
    _depths: Array  # of contacts at the last look, see `NativeItems.depths_of_contacts`
    _outrun = ""  # what is said of a given step that became too long
    _unsolvable = ""  # what was said of joints that could not be solved for
    _tracker: VibrationTracker | None = None

    @property
    def name(self) -> str:
        cables = listed([run.name for run in self._runs])
        joints = len(self._scene.joints)
        others = [f"{joints} joint(s)"] if joints else []
        others += ["bodies"] if self._scene.has_bodies else []
        return " and ".join([cables, *others]) if cables else "native items"

    @property
    def reason(self) -> str:
        """What an evaluation needs, or a step of compiled code."""
        if self.mover.asks:
            return f"each step asks {self.mover.asks}"
        joints, bodies = len(self._scene.joints), self._scene.bodies_of_variable_mass
        needs = ["one right-hand side of Exudyn"]
        if self._scene.parts_in_one:
            changing = len(self._scene.parts_in_one.form.numbers.changing_masses)
            masses = f"the mass of {changing} bodies" if changing else "no mass"
            needs += [f"{masses} and no Jacobian (bodies and joints are compiled)"]
        else:
            needs += [f"the mass of {bodies} bodies"] if bodies else ["no mass (all constant, inverted once)"]
            needs += [f"the Jacobians of {joints} joints"] if joints else ["no Jacobian (no joints)"]
        said = f"each evaluation takes {', '.join(needs)}, as mbs contains {self._why}"
        return f"{said}; Exudyn evaluates them because of {self.why_not}"

    @cached_property
    def _rates(self) -> FastestRates:
        return self._rates_at(self._time)

    @property
    def fastest(self) -> tuple[str, str]:
        """Which node vibrates fastest at the start, and the element of a native cable that it has, if any."""
        place = self._place_in(self._fastest[0, 0])
        return self._scene.coordinate_name(place), self._scene.native_cable_at(place)

    @property
    def most_damped(self) -> str:
        """Which node damping decays fastest at, at the start."""
        return str(self._scene.coordinate_name(self._place_in(self._fastest[0, 1])))

    def may_touch(self) -> bool:
        """Whether there is anything that may be hit."""
        return bool(self._scene.native_items.may_touch)

    def _place_in(self, motion: Array) -> int:
        """Of the coordinate that moves most, in the system vector."""
        return int(self.indices[int(np.argmax(np.abs(motion[: len(self.indices)])))])

    def _rates_at(self, time: float, in_motion: bool = False) -> FastestRates:
        """Of the present state."""
        with self._without_implicit_forces(time):
            scene = *self._system_at(time), self.state.q, self.state.v
            states = self._scene.system.states
            rates = fastest_rates(*scene, self._fastest[0], states=states, in_motion=in_motion)
            if self.has_states:
                self.frequency_of_states = frequency_of_states(*scene, states)
                self.swings_of_states = swings_of_states(*scene, states)
            return rates._replace(frequency=math.hypot(rates.frequency, self.frequency_of_states))

    def _system_at(self, time: float) -> tuple[Any, Array]:
        """What takes the steps, and the external force that it is given."""
        return self.mover.followed_system, self.mover.external_at(time)

    @contextmanager
    def _without_implicit_forces(self, time: float) -> Iterator[None]:
        """Damping and axial forces of cables, and damping of contact and dashpots, do not bound the step."""
        damping = [run.implicit_damping_left_out() for run in self._runs]
        with together([self.mover.implicit_damping_left_out(time), *damping]):
            if any(run.scene_cable.cable.stretches for run in self._runs):
                memory = np.zeros((2, len(self.state.q)))
                system, external = self._system_at(time)
                accelerate_and_project(system, external, self.state.q, self.state.v, 0.0, *memory)
            with together([run.axial_forces_frozen for run in self._runs]):
                yield

    @property
    def damps_implicitly(self) -> bool:
        """Whether dashpots of springs are implicit."""
        return self.mover.damps_implicitly

    @contextmanager
    def springs_left_out(self) -> Iterator[None]:
        """Springs that can be implicit do not bound the step."""
        kept = self._fastest.copy()
        with self.mover.springs_left_out(self._time):
            self.__dict__.pop("_rates", None)
            yield
        self.__dict__.pop("_rates", None)
        self._fastest[:] = kept

    def damp_implicitly(self, limit: float, undamped: float) -> bool:
        """Let springs and their dashpots bound the step no longer; whether any can be implicit.

        limit, undamped: of the step while they are explicit, with and without dashpots [s].
        """
        self.__dict__.pop("_rates", None)
        self.explicit_limits = limit, undamped
        return self.mover.damp_implicitly(SHARE * undamped)

    def forget_rates(self, time: float) -> None:
        """Find them again, for the configuration at `time` [s]; the run must then begin again."""
        self._time = time
        self.__dict__.pop("_rates", None)
        if self._tracker:
            self._tracker.vibration[:] = 0.0

    @cached_property
    def contacts(self) -> OpenContacts | None:
        """Contacts that are open at the start, if there are any."""
        state, implicit = (self._time, self.state.q, self.state.v), self.mover.implicit_contacts
        return self._scene.open_contacts(*state, self.data[0], implicit)

    @property
    def rates_in_contact(self) -> FastestRates:
        """The rates if all of these contacts close at once; zero where there are none."""
        if self.contacts is None:
            return FastestRates(0.0, 0.0)
        state, kept = (self.mover.given, self.state.q, self.state.v), self._fastest[1]
        with self._without_implicit_forces(self._time):
            return self.contacts.rates(*self._system_at(self._time), *state, kept)

    def largest_frequency(self, time: float) -> float:
        """w_max [rad/s] of small vibrations about the present configuration, joints included."""
        return self._rates.frequency

    def damping_ratio(self, frequency: float) -> float:
        """Strongest damping [1/s], as a share of that frequency."""
        ratio = self._rates.damping / frequency if frequency > 0.0 else 0.0
        return ratio if ratio > 1e-6 else 0.0

    def follow_frequency(self, rule: StepRule) -> None:
        """Let the steps follow the present stability limit."""
        self._tracker = VibrationTracker(self._scene.size)
        fewest, hides = FEWEST_BETWEEN_LOOKS, self._scene.has_hidden_changes
        looks = STEPS_BETWEEN_LOOKS, fewest, fewest if hides else MOST_BETWEEN_LOOKS
        follower = FrequencyFollower(rule, self._present_frequency, *looks)
        self.control = StepControl(follower, self._rejects)

    def _present_frequency(self, time: float) -> float:
        """w_max [rad/s] about the present state, of which the integrator then knows again."""
        assert self._tracker is not None
        with self._without_implicit_forces(time):
            scene = *self._system_at(time), self.state.q, self.state.v
            found = self._tracker.frequency(*scene)
            if self.has_states:
                states = self._scene.system.states
                rates = frequency_of_states(*scene, states), decay_of_states(*scene, states)
                found = math.hypot(found, *rates)
        self.resume(time)
        return found

    @property
    def has_states(self) -> bool:
        """Whether there are states of first order, as of oil, whose rates change by far during a run."""
        states = self._scene.system.states
        return bool(states.stop > states.start)

    def verdict(self, time: float, h: float) -> str:
        """What went wrong in the last steps; see `CableRun.verdict`."""
        if not self.gave_up:
            return ""
        if self.jump:
            return f"{self.name}: {self.known_cause(time)}"
        if self._unsolvable:
            smaller = "If the motion before that is wrong, reduce stepSize."
            parts = filter(None, (self._unsolvable, self.known_cause(time), smaller))
            return f"{self.name}: {' '.join(parts)}"
        limit, scaled = self._limits_now(time)[0], any(run.is_scaled for run in self._runs)
        said = self.known_cause(time) or explanation(
            self.integrator, self.trouble, self.control.present, limit, scaled
        )
        return f"{self.name}: {self.watch.found}; {self._place}; {self.control.said}. {said}"

    def straight_cables(self) -> list[str]:
        """See `PacedRun.straight_cables`."""
        return held_straight(self._scene, self.state.q, PULLED)

    def places(self, time: float) -> Array:
        """See `PacedRun.places`."""
        found = [run.loads.places(time) for run in self._runs]
        if self._scene.joints:
            found.append(self.mover.evaluated.violations(time, self.state.q))
        return np.concatenate([np.zeros(0), *found])

    @property
    def names_of_places(self) -> list[str]:
        names = [name for run in self._runs for name in run.loads.names_of_places]
        return [*names, *self._scene.native_items.joints] if self._scene.joints else names

    def look_for_jumps(self, piece: Piece) -> None:
        """Raise JumpError if a support or joint jumps in an interval; compiled ones look by themselves."""
        loads = [run.loads for run in self._runs]
        is_compiled = isinstance(self.mover, MovedByKernels)
        if is_compiled or not (self._scene.rows.follows_time or any(one.names_of_places for one in loads)):
            return
        least = max((one.sight.least for one in loads), default=0.0)
        ends = [piece.time(taken) for taken in range(0, piece.steps + 1, piece.in_interval)]
        look_between(self.places, ends, least)

    def outruns_limit(self, piece: Piece, since: int, done: int) -> bool:
        """Whether the steps of this piece are too long by now.

        since, done: how many of them had been taken at the last look, and have been taken now.
        As cables that stretch are pulled tight, or contacts that were open have closed, and rub. Then
        the nominal step is shorter from now on, or until contacts open; of a given one, `finding` tells.
        """
        tension = max((run.tension_by_mass for run in self._runs), default=0.0)
        is_tight = self._is_tighter(tension, piece.h)
        if self.control.follower or not (is_tight or self._looks_at_contacts(since, done)):
            return False
        time = piece.time(done)
        limit = self._limit_of_motion(time)
        share, divisor = self.control.nominal(piece.h) / limit, self.control.divisor
        is_longer = share > LARGEST_SHARE and self.watch.may_shorten
        parts = min(divisor * share / SHARE, MOST_PARTS)
        if is_tight or is_longer:
            self.control.divide_for_waves(math.ceil(parts) if is_longer else 1, tension)
        elif share < SMALLEST_SHARE:
            self.control.divide_again(math.ceil(parts), tension)
        if share > 1.0 and not self.watch.may_shorten:
            self._outrun = (
                f"at t = {time:.4g} s cables were pulled so tight that the stability limit fell to "
                f"{limit:.3g} s, below stepSize: forces may be far off; take stepSize = {SHARE * limit:.2g}."
            )
        return self.control.divisor > divisor

    def outran_limit(self, time: float) -> bool:
        """See `PacedRun.outran_limit`: springs vibrate, friction takes circles along, functions damp."""
        may = self.watch.may_shorten and not self.control.follower
        if may and self.watch.trouble == SPRINGS:
            return self._resolve_springs()
        if not (may and self.watch.trouble in OF_TOO_LONG_STEPS):
            return False
        return self._drags_circles() or (isinstance(self.mover, MovedByExudyn) and self._outran_damping(time))

    def _resolve_springs(self) -> bool:
        """Whether steps are shorter from now on, in which springs are explicit, as these vibrate."""
        divisor = self.control.divisor
        self._shorten_to(SHARE * self.explicit_limits[1])
        return self.control.divisor > divisor

    def _shorten_to(self, step: float) -> None:
        """Take no longer steps than that from now on [s]."""
        parts = math.ceil(self.control.divisor * self.control.largest / step)
        self.control.divide_for_waves(min(parts, MOST_PARTS), self.control.tension)

    def _drags_circles(self) -> bool:
        """Whether friction sways a circle at these steps; they are shorter then, up to a few times."""
        may = self.control.divisor < DRAGGING_PARTS * self.control.least
        if may and self.control.present * self.mover.rate_of_drag > MOST_DRAG:
            self.control.shorten(2)
            return True
        return False

    def _outran_damping(self, time: float) -> bool:
        """See `outran_limit`: functions of springs may damp in some states alone."""
        limit, undamped, damping = self._limits_of_motion(time)
        if self.control.largest <= LARGEST_SHARE * limit or undamped <= SLOWED * limit:
            return False
        self._shorten_to(SHARE * limit)
        self._outrun = (
            f"from t = {time:.4g} s on damping of {damping:.3g} 1/s at {self.name} bounds the step to "
            f"{limit:.3g} s, where {undamped:.3g} s hold without it: forces that Exudyn evaluates, as by "
            "user functions, are explicit; let these damp less, or act on heavier parts."
        )
        return True

    def _is_tighter(self, tension: float, h: float) -> bool:
        """Whether cables that stretch are pulled so much tighter that the limit must be found again."""
        bounds = max(TIGHTER * self.control.tension, SLOW_WAVES / h**2)
        return self.watch.stretches and tension > bounds and not self.control.is_shorter_for_a_while

    def _looks_at_contacts(self, since: int, done: int) -> bool:
        """Whether the limit is due to be found again, as contacts have changed that may change it."""
        may = self.watch.may_shorten and self.mover.follows_contacts
        is_due = since + steps_until_look(self.control.steps + since, STEPS_BETWEEN_LOOKS) <= done
        return may and (is_due or self.control.is_shorter_for_a_while) and self._have_contacts_changed()

    def _have_contacts_changed(self) -> bool:
        """Whether some have opened or closed since the last look, or are twice as deep or half as deep."""
        present = self.mover.depths_of_contacts
        if present is not None and np.array_equal(present, self._depths):
            return False
        self._depths[:] = 0.0 if present is None else present
        return True

    def is_stable(self, h: float, time: float) -> bool:
        """See `PacedRun.is_stable`: contacts that close, and what they rub, may have changed the limit."""
        return h <= LARGEST_SHARE * self._limit_of_motion(time)

    def _limit_of_motion(self, time: float) -> float:
        return self._limits_of_motion(time)[0]

    def _limits_of_motion(self, time: float) -> tuple[float, float, float]:
        """As `_limits_now`, of the present state, from which the run then goes on."""
        state = super().present_state()
        self._fastest[0] = 0.0  # a search that does not depend on earlier ones, for restart files
        limits = self._limits_now(time)
        state.restore()
        self.resume(time)
        return limits

    def _limits_now(self, time: float) -> tuple[float, float, float]:
        """In the state of the last inspection: stability limit [s], that without damping, damping [1/s].

        Infinite if there are none.
        """
        rates = self._rates_at(time, in_motion=True)
        if not rates.frequency > 0.0:
            return np.inf, np.inf, 0.0
        ratios = rates.damping / rates.frequency, 0.0
        with_damping, without = (frequency_limit(self.integrator, self.scheme, ratio) for ratio in ratios)
        return with_damping / rates.frequency, without / rates.frequency, rates.damping

    @property
    def _place(self) -> str:
        """Where the last good state has its largest acceleration."""
        largest = int(np.argmax(np.abs(self.state.a[: len(self.indices)])))
        return f"its accelerations are largest at {self._scene.coordinate_name(self.indices[largest])}"
