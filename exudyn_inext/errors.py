"""What can go wrong, as exception types. Every message says value, limit, culprit and remedy."""

from typing import Any


class InextensibleError(Exception):
    """Base of all errors that the package raises on purpose."""


class InputError(InextensibleError, ValueError):
    """An argument is outside of what the method or the implementation allows."""


class SceneError(InextensibleError, ValueError):
    """The mbs contains, or lacks, something that the explicit solver needs to know about."""


class StepSizeError(InextensibleError, ValueError):
    """The requested step is above the stability limit of the scheme."""


class EnforcementError(InextensibleError, RuntimeError):
    """A solver that does not enforce inextensibility evaluates an inextensible cable."""


class ExplicitTrapWarning(UserWarning):
    """A native explicit solver would compute a wrong motion, or none, without saying why."""


class RedundantConstraintError(InextensibleError, ArithmeticError):
    """The constraints of a cable are linearly dependent in the present configuration."""


class DivergenceError(InextensibleError, ArithmeticError):
    """The run left the finite numbers, or its constraints, or gained energy."""


class OffCableError(InextensibleError, ArithmeticError):
    """A body has slid beyond the end of its cable."""


class EquilibriumError(InextensibleError, ArithmeticError):
    """No stable static equilibrium was found.   report: figures and last state."""

    def __init__(self, message: str, report: dict[str, Any]) -> None:
        super().__init__(message)
        self.report = report
