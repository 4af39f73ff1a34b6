"""What a watch has found of a run, whatever it moves, and what follows for its steps."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..arrays import Array
from ..integrators.integrator import remembered
from .watch import (
    BEGINNING,
    CONSTRAINTS,
    ENERGY,
    FAILED,
    JUMP,
    LACK_OF_WORK,
    LARGEST_JUMP,
    LARGEST_VIOLATION,
    MOST_TURN,
    NOT_FINITE,
    NOW,
    SHARE_OF_EXTENT,
    SPRINGS,
    THROWN_OFF,
    TOO_FAST,
    TURNED,
    UNSTABLE,
    Watch,
)

SLOW = 16.0  # times the phase error: what it is with twice the step, and a margin of 4


class RunWatch:
    """A run's account and what it means; whoever knows the run draws it up.

    watch: the account.   stretches: whether one of its cables does.
    may_shorten: whether the nominal step may become shorter, as nobody has given it.
    """

    watch: Watch
    stretches: bool
    may_shorten = False

    def limit_phase(self, duration: float, phase: float, mesh: Array, small: float) -> None:
        """Let it find steps that are too long for the motion; arguments: see `Watch`."""
        self.watch = self.watch._replace(duration=duration, phase=phase, mesh=mesh, small=small)
        self.may_shorten = True

    def end_shortening(self) -> None:
        """The nominal step stays as it is."""
        self.watch, self.may_shorten = self.watch._replace(phase=math.inf), False

    def limit_phase_as(self, other: "RunWatch") -> None:
        """As the watch over another run."""
        watch = other.watch
        self.limit_phase(watch.duration, watch.phase, watch.mesh, watch.small)
        self.may_shorten = other.may_shorten

    @property
    def trouble(self) -> int:
        """What was wrong with the last steps, see `watch`."""
        return int(self.watch.account[NOW].trouble)

    @property
    def turned_over(self) -> float:
        """Energy that the motion has turned over so far [J], or that of round-off, if that is more."""
        account = self.watch.account  # of which account["name"][k] is six times faster than account[k].name
        elastic = account["largest_elastic"][NOW] - account["least_elastic"][NOW]
        return float(max(account["largest_kinetic"][NOW] + elastic, account["round_off"][NOW]))

    @property
    def frequency(self) -> float:
        """Of the vibrations that carry the motion so far, see `watch` [rad/s]."""
        account = self.watch.account[NOW]
        return math.sqrt(account["forces"] / account["speeds"]) if account["speeds"] > 0.0 else 0.0

    @property
    def gain(self) -> float:
        """Energy that the scheme has made so far, times its tolerance; 0 where the step is given."""
        return float(self.watch.account["error"][NOW]) / self.watch.tolerance if self.may_shorten else 0.0

    @property
    def resolving_step(self) -> float:
        """Step that resolves axial vibrations of the cables [s]; 0: nobody looks, or there are none."""
        squared, stiffness, *_ = self.watch.mesh
        return 0.5 * math.sqrt(squared) if stiffness == 0.0 else 0.0

    @property
    def hides_energy(self) -> bool:
        """Whether it is too long for a cable that stretches, or for a scheme that gains energy.

        Axial vibrations that it does not resolve hide energy, which shorter steps for a while would set free;
        what such a scheme has gained in a violent motion, shorter steps do not take back.
        """
        hidden = self.trouble in (ENERGY, JUMP, NOT_FINITE, UNSTABLE)
        return (self.stretches or self._gains_energy) and self.may_shorten and hidden

    def look_closer(self) -> bool:
        """Whether it may have looked too seldom at steps that went wrong, and looks more often from now on.

        The work of damping, drag and moving supports is that of their power at inspections: what axial waves
        change between two of them may look as if the energy jumped.
        """
        waves = self.stretches and self.watch.account["largest_power"][FAILED] > 0.0
        may_have = waves and self.trouble == JUMP
        return bool(may_have and self._shorten_interval())

    def _shorten_interval(self) -> bool:
        """Make the next inspection come sooner than the last one did; returns whether that is possible."""
        raise NotImplementedError

    @property
    def _gains_energy(self) -> bool:
        """Whether the scheme does, by itself."""
        return self.watch.most < math.inf

    @property
    def parts(self) -> int:
        """Of a step that is too long: a power of two, or fewer where its error then is that of the mesh."""
        found = self.watch.account[FAILED]
        if found.trouble != TOO_FAST:
            return 2
        halvings = max(1, math.ceil(0.5 * math.log2(max(found.phase / self.watch.phase, 1.0))))
        return math.ceil(min(2.0**halvings, math.sqrt(found.over_mesh)))

    @property
    def is_slow(self) -> bool:
        """Whether the motion so far allows much longer steps."""
        if self._gains_energy or not (self.may_shorten and SLOW * self._phase_to_grow < self.watch.phase):
            return False
        now = self.watch.account[NOW]
        has_turned = now.forces * now.time**2 > BEGINNING**2 * now.speeds
        return bool(has_turned and (self.watch.mesh[1] == 0.0 or not 0.25 < now.over_mesh < math.inf))

    @property
    def _phase_to_grow(self) -> float:
        """As if the motion had not gone anywhere, where its extent is not known [rad]."""
        account = self.watch.account
        phase = float(account["phase"][NOW])
        if account["extent"][NOW]:
            return phase
        return phase * SHARE_OF_EXTENT * self.frequency * float(account["time"][NOW]) / BEGINNING

    def expect_double_step(self) -> None:
        """The motion so far has this phase error at steps twice as long."""
        self.watch.account["phase"][NOW] *= 4.0

    @contextmanager
    def finding_kept(self) -> Iterator[None]:
        """The account is set to what it was before steps that went wrong: what was found of them stays."""
        found, trouble = self.watch.account[FAILED].copy(), self.watch.account[NOW].trouble
        yield
        self.watch.account[FAILED] = found
        self.watch.account[NOW].trouble = trouble

    def figures(self) -> dict[str, float]:
        """Extremes so far: 'energyGain', 'energyLoss' [-] and 'constraints' [-]; see `Watch`."""
        account = self.watch.account[NOW]
        return {
            "energyGain": float(account.gain),
            "energyLoss": -float(account.loss),
            "constraints": float(account.violation),
        }

    def memory(self) -> dict[str, Any]:
        """Arrays that the next inspections depend on, by names."""
        names = ("account", "flight", "position", "work", "kept_work", "energy_report")
        return {name: getattr(self.watch, name) for name in names} | {"kept": remembered(self.watch.kept)}

    @property
    def found(self) -> str:
        """What went wrong, and by how much."""
        watch, account = self.watch, self.watch.account[FAILED]
        much = float(account.error)
        said = {
            CONSTRAINTS: "inextensibility or another constraint is violated by "
            f"{account.violation:.2g} (limit {LARGEST_VIOLATION:g})",
            ENERGY: f"it has more energy than the work done on it explains, by {much:.2%} of the energy of "
            f"its motion (limit {watch.most:.2%})",
            LACK_OF_WORK: "forces change so much within a step that their work is wrong by "
            f"{much:.2%} of the energy of its motion",
            SPRINGS: "springs that are implicit at this step vibrate with energy that is wrong by "
            f"{much:.2%} of the energy of its motion",
            UNSTABLE: f"the largest frequency of its motion is {much:.3g} times the one up to which the step "
            "is stable",
            THROWN_OFF: f"contact throws a body off at {much:.3g} m/s, faster than it came, within a step",
            TURNED: f"a spring that counts turns is turned by {much:.3g} rad within a step (limit "
            f"{MOST_TURN:.3g} rad)",
            JUMP: f"its energy jumps by more than {LARGEST_JUMP * watch.tolerance:.2%} of the energy of its "
            "motion within a few steps",
        }
        return said.get(int(account.trouble), "its coordinates are not finite any more")
