"""What can go wrong, as exception types. Every message says value, limit, culprit and remedy."""

from typing import Any


class InextensibleError(Exception):
    """Base of all errors that the package raises on purpose."""


class InputError(InextensibleError, ValueError):
    """An argument, or a time of the settings, is outside of its limits, or a file cannot be written."""


class SceneError(InextensibleError, ValueError):
    """The mbs is not assembled, is inconsistent, or contains what a solver of this package cannot take."""


class StepSizeError(InextensibleError, ValueError):
    """The requested step is above the stability limit of the scheme."""


class EnforcementError(InextensibleError, RuntimeError):
    """A native solver, which does not keep the length of a cable, evaluates it; see `enforcement`.

    Exudyn raises a ModelError of its own, with this error and its message as text.
    """


class ExplicitTrapWarning(UserWarning):
    """A warning: a native explicit solver would compute a wrong motion, or none, without saying why."""


class RedundantConstraintError(InextensibleError, ArithmeticError):
    """Constraints of cables or joints depend on each other in the present configuration."""


class DivergenceError(InextensibleError, ArithmeticError):
    """The run left the finite numbers, or its constraints, or gained energy; mbs has the last good state.

    shorter_step: that may go well where axial vibrations seem to be the cause [s]; 0: not known.
    """

    shorter_step = 0.0


class OffCableError(InextensibleError, ArithmeticError):
    """A body has slid beyond the end of its cable."""


class EquilibriumError(InextensibleError, ArithmeticError):
    """No stable static equilibrium was found; mbs is unchanged.   report: figures and last state."""

    def __init__(self, message: str, report: dict[str, Any]) -> None:
        super().__init__(message)
        self.report = report
