"""Whether friction of cables on circles obeys Coulomb's law, which Exudyn's contact does not always do.

Where frictionStiffness and frictionVelocityPenalty are both given, Exudyn's slip acts against the
displacement since the last sticking, not against the velocity. If slip turns round faster than this
displacement, as it does beside a strong frictionVelocityPenalty, friction drives it. In the first step of
a contact this displacement is zero, and the contact sticks with any force. Both depend on the step, under
Exudyn's own solvers, too.
"""

from typing import Any

import exudyn
import numpy as np

from ..arrays import Array

LARGEST_SHARE = 0.05  # of the work of friction that may contradict Coulomb's law
STEPS_BETWEEN = 16  # two looks at contacts that last
LEAST_LOOKS = 10  # at a contact that lasts, before anything is said
_CAUSES = ("frictionStiffness", "frictionVelocityPenalty")
_SLIP, _STICK, _OPEN = 1.0, 0.0, -2.0  # what Exudyn remembers of a segment; slip has a sign
_VELOCITY, _FORCE = exudyn.OutputVariableType.Coordinates_t, exudyn.OutputVariableType.ForceLocal


class FrictionCheck:
    """Compares friction with Coulomb's law, step by step.

    numbers: of the objects that are looked at.
    sums: (contacts, 4) of each contact: powers summed over steps [W], of friction that drives slip, of that
        above the limit of sticking, and of all; and how often it was looked at while it lasted.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs = mbs
        system = mbs.systemData
        objects = range(system.NumberOfObjects() if system.DataSize() else 0)  # contact remembers
        self.numbers = [number for number in objects if _is_checked(mbs.GetObject(number))]
        places = [np.array(system.GetObjectLTGData(number), dtype=int) for number in self.numbers]
        self._states = [own[len(own) // 3 : 2 * len(own) // 3] for own in places]
        self._limits = [mbs.GetObject(number)["frictionCoefficient"] for number in self.numbers]
        self._steps = 0
        self.sums = np.zeros((len(self.numbers), 4))
        self.begin()

    def begin(self) -> None:
        """The next step starts from what contacts remember at present."""
        self._before = np.array(self._mbs.systemData.GetDataCoordinates())

    def look(self) -> None:
        """At the end of a step: at contacts that have just closed, from time to time at all of them."""
        data = np.array(self._mbs.systemData.GetDataCoordinates())
        closed = (data == _STICK) & (self._before == _OPEN)
        self._before = data
        self._steps += 1
        is_due = self._steps % STEPS_BETWEEN == 0
        if not (is_due or closed.any()):
            return
        for contact, places in enumerate(self._states):
            if closed[places].any() or (is_due and (data[places] != _OPEN).any()):
                self._count(contact, data[places], closed[places], STEPS_BETWEEN * is_due)

    def _count(self, contact: int, state: Array, closed: Array, weight: int) -> None:
        """Add powers.   state, closed: (segments,).   weight: of those that last, in steps."""
        number, total = self.numbers[contact], self.sums[contact]
        velocity = np.array(self._mbs.GetObjectOutput(number, _VELOCITY))[::2]
        force, normal = np.reshape(self._mbs.GetObjectOutput(number, _FORCE), (-1, 2)).T
        power = force * velocity
        above = np.abs(force) - self._limits[contact] * np.abs(normal)
        lasts = (state != _OPEN) & np.logical_not(closed)
        drives = (np.abs(state) == _SLIP) & (power < 0.0)
        total[0] -= weight * power[drives].sum()
        total[1] += (np.maximum(above, 0.0) * np.abs(velocity))[closed].sum()
        total[2] += np.abs(power) @ (weight * lasts + closed)
        total[3] += bool(weight) and bool(lasts.any())

    @property
    def finding(self) -> str:
        """What contradicts Coulomb's law, culprit and remedy; empty if little does."""
        driving, above, everything, looks = self.sums.sum(axis=0)
        if looks < LEAST_LOOKS or driving + above <= LARGEST_SHARE * everything:
            return ""
        smaller = "reduce stepSize, or " if above > driving else ""
        wrong = driving + above
        return (
            f"{self._culprit()}: {wrong / everything:.1%} of the work of friction contradicts Coulomb's law "
            f"(limit {LARGEST_SHARE:.0%}): {driving / everything:.1%} drives slip, whose direction Exudyn "
            f"takes from the displacement since the last sticking; {above / everything:.1%} is above the "
            "limit of sticking in first steps of contacts. The motion then depends on the step, under "
            f"Exudyn's own solvers, too: {smaller}set frictionStiffness = 0, or lower "
            "frictionVelocityPenalty."
        )

    def _culprit(self) -> str:
        """The contact with most of it, and how many there are besides."""
        number = self.numbers[int(np.argmax(self.sums[:, 0] + self.sums[:, 1]))]
        data = self._mbs.GetObject(number)
        given = ", ".join(f"{name} = {data[name]:g}" for name in _CAUSES)
        others = f" and {len(self.numbers) - 1} more like it" if len(self.numbers) > 1 else ""
        return f"object {number} '{data['name']}' ({data['objectType']}: {given}){others}"


def _is_checked(data: dict[str, Any]) -> bool:
    """Whether an object has friction that may contradict Coulomb's law."""
    is_circle = data["objectType"] == "ContactFrictionCircleCable2D" and data["activeConnector"]
    return bool(is_circle and all(data[name] for name in _CAUSES))
