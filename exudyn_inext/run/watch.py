"""A watch over a run: whether it stays finite, on its constraints, and with the energy that it should have.

That is the energy of its start and the work done since; what it has beyond that, the scheme has made. Every
few steps the account is drawn up, and the state kept, so that a run can go on from the last good one.

It also looks at how fast the motion is: the vibrations that carry it, of the frequency

    w^2 = int a . M a dt / int v . M v dt,

have a phase error of w T (h w)^2 / 24 after a time T under a scheme of central differences. That counts the
less the smaller their amplitude is, relative to the way of the motion so far: by 1 / (w t). Where the extent
X of the motion is known, |x - x_0| in the metric of M, their amplitude |v| / w counts relative to that.
Errors of places below a share of the cables' length do not count, nor do such vibrations. An
error above 1 rad counts by its cube root: in a mixture of waves, v is that of slower ones, whose errors are
smaller, and min(1, (w / w_1)^3) <= w / w_1, where w_1 is the frequency that makes 1 rad. As long as a motion
goes one way, |v| t near X, its extent grows faster than errors of small waves: it is not judged yet.

Of a scene, each cable and each body is judged by itself, see `moving_parts`: a light one has no share in the
energy of the others. What an account says of the motion is then that of the part with the largest error.

Where bending carries the waves of a cable, its mesh has a phase error, too. A step whose error is no larger
is short enough, whatever their frequency: both errors grow with the fourth power of the wave number.

Of a run that nothing ties to its surroundings, all that is as a frame sees it that flies along, see `Flight`.

Implicit axial vibrations that the step does not resolve are left out of a, as shorter steps would not make
them more accurate before they resolve them.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..compiled import called_kernel, inlined, kernel
from ..integrators.integrator import FACTOR, FIRST, LAST, PROJECTION, SUM, LoadHistory, advance
from ..system import ELASTIC, KINETIC, POWER, REPORTED, RESOLVED, VIOLATION, report_energy

NOW, KEPT, FAILED = range(3)  # accounts
ALL_IS_WELL, NOT_FINITE, CONSTRAINTS, ENERGY, JUMP, TOO_FAST = range(6)
LACK_OF_WORK, UNSTABLE, THROWN_OFF, TURNED, SPRINGS = range(6, 11)

STEPS_BETWEEN = 160  # inspections of a run whose energy only forces change
STEPS_WITH_POWER = 80  # of one with damping, drag, or supports that move, at most
LEAST_STEPS = 4  # at the beginning, and where the power changes fast
BENT, STRAIGHT = 0.2, 0.05  # change of the power's rise, over its largest value, for fewer and for more steps
LARGEST_VIOLATION = 0.05  # of |r_x|^2 = 1 [-], and of lengths, relative
LARGEST_JUMP = 1.0  # of the energy between two inspections, times the tolerance
VIOLENT = 30.0  # times the tolerance: what a scheme that gains energy may gain altogether
MOST_TURN = 0.5 * np.pi  # in a step [rad], of a spring that counts turns
MOTION = 1e-3  # times the bound of the energy's round-off: less is none
SAMPLED = 20.0  # phase [rad] up to which inspections are at most 1 rad apart
BEGINNING = 10.0  # phase [rad] of the motion before which its frequency is not known
LONG = 30.0  # and, but for an inextensible cable alone, before which waves of a sudden start have not passed
RETURNED = 3.0  # |v| t over the extent of a motion that has come back
SMALL = 1e-5  # error of places, over the length of the cable, that counts for nothing
OF_EXTENT = 0.01  # of a part among others, that its error is compared with
MOST_PHASE = 2.0  # error of a vibration's place, over its amplitude
WAITING = 0.25  # share of the run after which neither counts any more
ONE_WAY = 0.5  # share after which it is judged, though it has not come back
TOO_LATE = 0.8  # share of the run after which shorter steps mend too little of an error already made
SHARE_OF_EXTENT = 0.3  # so that a phase error of 0.003 is one of 1 % of the extent
SHARE_OF_POWER = 0.02  # that its sum over time may be wrong by
SHARE_OF_TOLERANCE = 0.1  # that one interval may leave in doubt, before inspections come closer
SCATTER = 4.0  # times its standard deviation may the work of forces be wrong

NO_MESH = np.zeros(4)

OF_MOTION = (
    *("surplus", "time", "forces", "speeds", "extent", "floor", "work", "scatter", "scattered", "slope"),
    *("largest_power", "error"),
)  # numbers of an account that begin at zero

_REAL = (
    *("start", "surplus", "time", "forces", "speeds", "phase", "over_mesh", "extent", "floor", "round_off"),
    *("acceleration_energy", "work", "unsure", "scatter", "scattered", "slope", "largest_power"),
    *("largest_kinetic", "least_elastic", "largest_elastic", "error", "gain", "loss", "violation"),
)
_WHOLE = ("steps", "ahead", "trouble")
ACCOUNT = record_type([(name, np.float64) for name in _REAL] + [(name, np.int64) for name in _WHOLE])


class Watch(NamedTuple):
    """What a watch knows of a run.

    every, least: steps between two inspections, at most and at least.
    tolerance: energy that a run may gain, as a share of what its motion turns over [-].
    most: as `tolerance`, of a scheme that gains energy: with more, it has diverged.
    duration: T of the run [s].   phase: error that the step may cause in it [rad], see above.
    mesh: (4,) of the mesh that errors of the step are compared with, see `resolution_of_mesh`; or `NO_MESH`.
    small: x . M x / 2 of an error x that counts for nothing [J s^2].
    account: (3,) records, NOW, KEPT and FAILED. Energy at the `start`, `acceleration_energy` then
        [J/s^2]; its present `surplus` [J]; `time` of motion since then [s], and the integrals of `forces`,
        a . M a / 2 [J/s], and `speeds`, v . M v / 2 [J s], over it, and the `phase` error of the run
        that they let expect [rad]; the error of the step in waves `over_mesh`, relative to that of the
        mesh [-]; the largest `extent` so far, x . M x / 2 [J s^2], or 0: not known, and the `floor` of
        one that errors are compared with; its `round_off` [J]; `work` done since [J], of which we are
        `unsure`, to one side [J], and its `scatter` [J^2], `scattered` until the last inspection; the `slope`
        of the power [W/s], whose changes tell how well trapezoids fit, and the `largest_power` so far [W];
        bounds of kinetic and elastic energy so far [J]; relative `error` of the energy and its extremes so
        far, `gain` and `loss` [-]; largest `violation` of a constraint so far [-]; how many `steps` were
        found well so far, how many are `ahead` of the next inspection; what the `trouble` is.
    flight: (2, n_dof) velocities and momenta of a frame that flies along with the motion, see `Flight`.
    position: (n_dof,) when work was counted last.
    pattern, work: (P, n_dof), (P, 5) of load histories, see `LoadHistory`.
    kept_work: at the last inspection.
    energy_report: (6,) at the last inspection, see `report_energy`.   force, present_report: memory.
    kept: state of the integrator at the last inspection; if it found trouble, the state that it found.
    """

    every: int
    least: int
    tolerance: float
    most: float
    duration: float
    phase: float
    mesh: Array
    small: float
    account: Any
    flight: Array
    position: Array
    pattern: Array
    work: Array
    kept_work: Array
    energy_report: Array
    force: Array
    present_report: Array
    kept: Any


def build_watch(
    state: Any,
    every: int,
    tolerance: float,
    pattern: Array | None = None,
    least: int | None = None,
    most: float = np.inf,
) -> Watch:
    """A watch over the run of an integrator's `state`; `open_account` begins it.

    pattern: (P, n_external) of load histories; None: there are none.   least: default: `every`.
    Other arguments: see `Watch`; nobody looks at the phase yet.
    """
    size = len(state.q)
    own = np.zeros((0, size)) if pattern is None else np.ascontiguousarray(pattern[:, :size])
    account = np.zeros(3, ACCOUNT)
    account["ahead"] = every
    return Watch(
        every,
        every if least is None else least,
        tolerance,
        most,
        duration=1.0,
        phase=np.inf,
        mesh=NO_MESH,
        small=0.0,
        account=account,
        flight=np.zeros((2, size)),
        position=np.zeros(size),
        pattern=own,
        work=_no_work(own),
        kept_work=_no_work(own),
        energy_report=np.zeros(REPORTED),
        force=np.zeros(size),
        present_report=np.zeros(REPORTED),
        kept=type(state)(*[memory.copy() for memory in state]),
    )


def _no_work(pattern: Array) -> Array:
    """(P, 5); a motion, which is no force, has no coordinates and does no work."""
    work = np.zeros((len(pattern), 5))
    work[:, LAST] = -1.0
    for row, of_load in zip(work, pattern, strict=True):
        places = np.flatnonzero(of_load)
        if len(places):
            row[FIRST], row[LAST] = places[0], places[-1]
    return work


@inlined
def _keep(watch, state):
    """As `keep`."""
    for memory in range(len(state)):
        kept, now = watch.kept[memory], state[memory]
        for i in range(len(now)):
            kept[i] = now[i]
    for i in range(len(watch.energy_report)):
        watch.energy_report[i] = watch.present_report[i]
    for p in range(len(watch.work)):
        for i in range(watch.work.shape[1]):
            watch.kept_work[p, i] = watch.work[p, i]
    watch.account[KEPT] = watch.account[NOW]


def keep(watch: Watch, state: Any) -> None:
    """Make this the last good state."""
    for kept, now in zip(watch.kept, state, strict=True):
        kept[:] = now
    watch.energy_report[:] = watch.present_report
    watch.kept_work[:] = watch.work
    watch.account[KEPT] = watch.account[NOW]


def go_back(watch: Watch, state: Any) -> None:
    """The state is the last good one again; the other one is kept, for whoever looks for the cause."""
    for kept, now in zip(watch.kept, state, strict=True):
        kept[:], now[:] = now.copy(), kept.copy()
    watch.position[:] = state.q
    watch.work[:] = watch.kept_work
    account = watch.account
    account[FAILED] = account[NOW]
    account[NOW] = account[KEPT]
    account[NOW].trouble = account[FAILED].trouble
    account[NOW].ahead = _first_steps(watch)


def _first_steps(watch: Watch) -> int:
    """Before the first inspection."""
    return max(watch.least, min(watch.every, LEAST_STEPS))


def open_account(watch: Watch, state: Any, round_off: float, seen: float) -> None:
    """Begin with a state, of which `present_report` is; extremes so far are kept.

    round_off: of its energy [J].   seen: its kinetic energy, as the frame sees it that flies along [J].
    """
    kinetic, elastic = watch.present_report[KINETIC], watch.present_report[ELASTIC]
    account = watch.account[NOW : NOW + 1]
    account["start"] = kinetic + elastic
    for name in OF_MOTION:
        account[name] = 0.0
    account["acceleration_energy"] = watch.present_report[RESOLVED]
    account["unsure"] = account["round_off"] = round_off
    account["ahead"] = _first_steps(watch)
    account["largest_kinetic"] = seen
    account["least_elastic"] = account["largest_elastic"] = elastic
    account["trouble"] = ALL_IS_WELL
    watch.position[:] = state.q
    watch.work[:, SUM], watch.work[:, FACTOR] = 0.0, np.inf  # that is known from the first step on
    watch.work[:, PROJECTION] = watch.pattern @ state.q
    keep(watch, state)


def go_on(watch: Watch, state: Any) -> None:
    """After a change of the step, and so of the mass: the energy is another one, its surplus is not.

    The `present_report` is of the state.
    """
    account, now = watch.account, watch.present_report
    energy = now[KINETIC] + now[ELASTIC]
    account["start"][NOW] = energy - account["work"][NOW] - account["surplus"][NOW]
    keep(watch, state)


@inlined
def _add_work_of_loads(watch, constant, q):
    """Work of the constant forces since the last call, and of the load histories, counted step by step."""
    account = watch.account[NOW]
    for i in range(len(watch.position)):
        account.work += constant[i] * (q[i] - watch.position[i])
        watch.position[i] = q[i]
    for p in range(len(watch.work)):
        account.work += watch.work[p, SUM]
        watch.work[p, SUM] = 0.0


@inlined
def _look_ahead(watch, steps, duration, turned_over):
    """How well the power is known between inspections, and when the next one is due.

    turned_over: energy that the motion has, so far [J].
    """
    account, power = watch.account[NOW], watch.present_report[POWER]
    slope = (power - watch.energy_report[POWER]) / duration
    bend = duration * abs(slope - account.slope)
    doubt = duration / 8.0 * bend  # enough for a power that falls to nothing at once
    trembles = slope * account.slope < 0.0
    account.slope = slope
    account.largest_power = max(account.largest_power, abs(power))
    is_bent = bend > BENT * account.largest_power
    account.scatter += doubt**2
    least = watch.least if trembles else max(watch.least, LEAST_STEPS)
    small = SHARE_OF_TOLERANCE * watch.tolerance * turned_over
    is_clear = steps >= account.ahead and doubt <= STRAIGHT * small
    if is_bent or (trembles and doubt > small):
        account.ahead = max(min(least, account.ahead), account.ahead // 2)
    elif bend <= STRAIGHT * account.largest_power and (is_clear or watch.least >= LEAST_STEPS):
        account.ahead = min(watch.every, 2 * account.ahead)


@inlined
def _see_in_flight(watch, constant, v, duration):
    """Kinetic energy as the frame sees it that flies along [J]; the work becomes that which it sees."""
    account, speeds, momenta, before = watch.account[NOW], watch.flight[0], watch.flight[1], watch.kept.v
    seen = watch.present_report[KINETIC]
    for i in range(len(momenta)):
        account.work += momenta[i] * (v[i] - before[i]) - duration * speeds[i] * constant[i]
        seen -= momenta[i] * (v[i] - 0.5 * speeds[i])
    return seen


@inlined
def _draw_up(watch, steps, duration, seen):
    """The present error of the energy, beyond what the account itself may be wrong by; returns its jump.

    seen: kinetic energy, as a frame sees it that flies along; so it does the work that has been counted [J].

    A central difference scheme keeps the energy less h^2 a . M a / 8, exactly if the system is linear: so
    much is in vibrations that the step does not resolve. Implicit ones keep it as it is.
    """
    account, now = watch.account[NOW], watch.present_report
    by_power = 0.5 * (watch.energy_report[POWER] + now[POWER]) * duration
    account.work += by_power
    account.unsure += SHARE_OF_POWER * abs(by_power)
    account.largest_kinetic = max(account.largest_kinetic, seen)
    account.least_elastic = min(account.least_elastic, now[ELASTIC])
    account.largest_elastic = max(account.largest_elastic, now[ELASTIC])
    turned_over = account.largest_kinetic + account.largest_elastic - account.least_elastic
    _look_ahead(watch, steps, duration, turned_over)
    error = now[KINETIC] + now[ELASTIC] - account.start - account.work
    unresolved = 0.25 * (duration / steps) ** 2 * (account.acceleration_energy + now[RESOLVED])
    unsure = account.unsure + SCATTER * np.sqrt(account.scatter) + unresolved
    scattered = SCATTER * np.sqrt(account.scatter - account.scattered)
    doubt = SHARE_OF_POWER * abs(by_power) + scattered + unresolved + account.round_off
    account.scattered = account.scatter
    jump = (error - account.surplus - doubt) / max(turned_over, unsure)
    account.surplus = error
    account.error = np.copysign(max(abs(error) - unsure, 0.0), error) / max(turned_over, unsure)
    account.gain = max(account.gain, account.error)
    account.loss = min(account.loss, account.error)
    account.violation = max(account.violation, now[VIOLATION])
    return jump


@inlined
def _errors_of_waves(mesh, squared, h_squared):
    """Relative errors of the squared frequency of a wave [-]: of the step, and of the mesh.

    By w^2 = w_b^2 + c^2 k^2, w_b = s k^2, the wave has the number k. Cubic elements raise w_b^2 by
    (k l)^4 / 720, relative. The step raises w^2 by (h w)^2 / 12, and mass scaling lowers it by
    theta (h w_b)^2; where these cancel, the first one counts.

    Without s, the first number of the mesh is the square of a step that is short enough [s^2], and all waves
    count as bending ones.

    mesh: see `Watch`.   squared: w^2 [rad^2/s^2].   h_squared: [s^2].
    """
    tension, stiffness, length, theta = mesh[0], mesh[1], mesh[2], mesh[3]
    if stiffness == 0.0 or not squared > 0.0:
        return h_squared * squared * max(1.0 / 12.0, theta - 1.0 / 12.0), tension * squared / 12.0
    number = 2.0 * squared / (np.sqrt(tension**2 + 4.0 * stiffness * squared) + tension)  # k^2
    bending = stiffness * number**2
    of_step = h_squared * max(squared / 12.0, theta * bending - squared / 12.0)
    return of_step, bending / squared * (number * length**2) ** 2 / 720.0


@inlined
def _count_motion(watch, duration, seen):
    """What rests before the motion begins is no part of it.   seen: see `_draw_up`."""
    account, now = watch.account[NOW], watch.present_report
    if max(account.largest_kinetic, seen) > MOTION * account.round_off:
        account.time += duration
        account.forces += now[RESOLVED] * duration
        account.speeds += seen * duration


@inlined
def _is_too_fast(watch, steps, duration):
    """Whether the motion so far is too fast for the step."""
    account = watch.account[NOW]
    if not account.speeds > 0.0:
        return False
    squared = account.forces / account.speeds
    turned = np.sqrt(squared) * account.time
    of_step, of_mesh = _errors_of_waves(watch.mesh, squared, (duration / steps) ** 2)
    account.over_mesh = of_step / of_mesh if of_mesh > 0.0 else np.inf
    rate, has_returned = 0.5 * of_step * np.sqrt(squared), True
    at_end = min(rate * watch.duration, MOST_PHASE)
    matters = account.speeds * at_end**2 > watch.small * account.time * squared
    if account.extent > 0.0:
        amplitude = np.sqrt(account.speeds / (account.time * max(account.extent, account.floor) * squared))
        made = rate * account.time
        made = min(made, made ** (1.0 / 3.0))
        account.phase = SHARE_OF_EXTENT * amplitude * made * watch.duration / account.time
        passed = account.time  # in which a share of the error has been made
        has_returned = account.speeds * account.time > RETURNED**2 * account.extent
    else:
        account.phase = rate * watch.duration * BEGINNING / turned
        passed = watch.duration
    if watch.mesh[1] > 0.0 and turned < SAMPLED and steps * account.time < account.ahead * turned * duration:
        account.ahead = max(watch.least, int(steps * account.time / (turned * duration)))
    is_much = account.phase * passed > watch.phase * watch.duration
    waiting = ONE_WAY if account.extent > 0.0 else WAITING
    is_late = account.time > waiting * watch.duration or watch.mesh[1] > 0.0
    is_known = turned > BEGINNING and (is_late or (turned > LONG and has_returned))
    pays = account.extent == 0.0 or account.time < TOO_LATE * watch.duration
    return is_known and is_much and matters and pays and account.over_mesh > 1.0


@inlined
def _is_finite(energy_report):
    """By comparison: np.isfinite(x) is x - x == x - x, which reassociation of sums folds."""
    finite = True
    for i in range(len(energy_report)):
        finite = finite and abs(energy_report[i]) < np.inf
    return finite


@kernel
def check_velocities(q, v, a):
    """v . v, or infinity if anything in q, v or a (n,) is not finite."""
    square, finite = 0.0, True
    for i in range(len(v)):
        square += v[i] * v[i]
        finite = finite and abs(q[i]) < np.inf and abs(a[i]) < np.inf
    return square if finite and square < np.inf else np.inf


@inlined
def _verdict(watch, steps, duration, seen):
    """What the trouble is after some steps whose work is counted.   seen: see `_draw_up`."""
    account, now = watch.account[NOW], watch.present_report
    account.trouble = ALL_IS_WELL
    if not _is_finite(now):
        account.trouble = NOT_FINITE
    else:
        jump = _draw_up(watch, steps, duration, seen)
        if now[VIOLATION] > LARGEST_VIOLATION:
            account.trouble = CONSTRAINTS
        elif account.error > watch.most:
            account.trouble = ENERGY
        elif jump > LARGEST_JUMP * watch.tolerance:
            account.trouble = JUMP
        elif _is_too_fast(watch, steps, duration):
            account.trouble = TOO_FAST
    if account.trouble == ALL_IS_WELL:
        account.steps += steps
    return account.trouble


def condemn(watch: Watch, state: Any, trouble: int, excess: float) -> None:
    """The last steps went wrong, as others have found; the state is that of the last inspection.

    trouble: what it is.   excess: how much of it, as the account's `error` [-].
    """
    watch.account[NOW].trouble = trouble
    watch.account[NOW].error = excess
    go_back(watch, state)


@inlined
def verdict_after_work(watch, q, seen, constant, work, scatter, steps, duration):
    """Draw up the account with `present_report`, after work that was counted elsewhere.

    Args:
        watch: over the run; nothing need be `kept`.   q: (n_dof,) present coordinates.
        seen: kinetic energy, as the frame sees it that flies along [J].
        constant: (n_dof,) force whose work is counted here.
        work: of the other forces [J].   scatter: of that work [J^2].
        steps, duration: since the last time [-, s].

    Returns:
        What the trouble is; if there is any, `go_back`, and else `keep`.
    """
    account = watch.account[NOW]
    account.work += work
    account.scatter += scatter
    _add_work_of_loads(watch, constant, q)
    return _verdict(watch, steps, duration, seen)


@inlined
def count_impulses(watch, state):
    """As `go_on`, after impulses: their work p . (v + v') / 2 is the change of the energy.

    The energy before is that of the last inspection, which was in this state.
    """
    now, before = watch.present_report, watch.energy_report
    watch.account[NOW].start += now[KINETIC] + now[ELASTIC] - before[KINETIC] - before[ELASTIC]
    _keep(watch, state)


@called_kernel
def record_watched(scheme, system, loads, state, h, steps, history, watch):
    """Advance through intervals of `steps` steps each, as long as all is well.

    Args:
        scheme, system, loads, state, h: see `advance`.   steps: in each interval.
        history: (intervals, 3, n_dof) output q, v, a at the end of each interval.
        watch: over the run, `placed`; its account is open.

    Returns:
        Number of intervals that ended well. If not all did, `go_back`.
    """
    done, total = 0, len(history) * steps
    while done < total:
        first, ahead = done // steps, watch.account[NOW].ahead
        if steps > ahead or done % steps:
            number = min(ahead, steps - done % steps)
            last, of_interval = first + 1, number
        else:
            last = min(first + ahead // steps, len(history))
            number, of_interval = (last - first) * steps, steps
        part = LoadHistory(loads.constant, loads.pattern, loads.factor[done : done + number], watch.work)
        advance(scheme, system, part, state, h, of_interval, history[first:last])
        report_energy(system, state.external, state.q, state.v, state.a, watch.force, watch.present_report)
        _add_work_of_loads(watch, loads.constant, state.q)
        seen = _see_in_flight(watch, loads.constant, state.v, number * h)
        _count_motion(watch, number * h, seen)
        if _verdict(watch, number, number * h, seen) != ALL_IS_WELL:
            return first
        _keep(watch, state)
        done += number
    return len(history)
