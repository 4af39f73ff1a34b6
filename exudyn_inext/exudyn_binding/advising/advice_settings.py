"""How `Advise` runs its pilots."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...checks import require_functions, require_integer, require_positive
from ...errors import InputError
from .pilot_runs import Build

NUMBERS = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96)
SAMPLES = 500
MOST_SAMPLES = 1e6
LARGEST_NUMBER = 100_000
OPTIONAL = ("samplePeriod", "axialStiffness")


@dataclass(frozen=True)
class AdviceSettings:
    """How pilots are run.

    Args:
        samplePeriod: [s] at which the sensor is compared; None: a five hundredth of endTime.
        numbersOfElements: that pilots may have, increasing; those that cannot be built are left out.
        pilotBudget: CPU time that solutions on finer and finer meshes may take together [s].
        axialStiffness: EA of the real cables [N]; None: stretch is not looked at.
        buildConventional: function of a number of elements that builds the same scene with native cables,
            returning (mbs, sensorNumber); None: native cables are not compared.
        dependsOnTimeOnly: user functions that depend on the time alone, see ExplicitSettings.
    """

    samplePeriod: float | None = None
    numbersOfElements: Sequence[int] = NUMBERS
    pilotBudget: float = 20.0
    axialStiffness: float | None = None
    buildConventional: Build | None = None
    dependsOnTimeOnly: bool | Sequence[Any] | None = None

    def __post_init__(self) -> None:
        """Check all of them.

        Raises:
            InputError: a number out of range, or numbers of elements that do not increase.
        """
        for name in ("samplePeriod", "pilotBudget", "axialStiffness"):
            if getattr(self, name) is not None or name not in OPTIONAL:
                object.__setattr__(self, name, require_positive(name, getattr(self, name)))
        numbers = self.numbersOfElements
        if not isinstance(numbers, list | tuple) or len(numbers) < 3:
            raise InputError(f"numbersOfElements = {numbers!r}: must be a list of at least three integers.")
        checked = [require_integer("numbersOfElements", n, 1, LARGEST_NUMBER) for n in numbers]
        if sorted(set(checked)) != checked:
            raise InputError(f"numbersOfElements = {numbers!r}: must increase.")
        require_builder("buildConventional", self.buildConventional, optional=True)
        require_functions("dependsOnTimeOnly", self.dependsOnTimeOnly)


def require_builder(name: str, build: Any, optional: bool = False) -> None:
    """Raise InputError for what cannot build a scene."""
    if not callable(build) and not (optional and build is None):
        raise InputError(
            f"{name} = {build!r}: must be a function of a number of elements that returns "
            "(mbs, sensorNumber)."
        )
