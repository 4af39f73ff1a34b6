"""Settings of SolveExplicit."""

import math
from collections.abc import Callable, Sequence
from dataclasses import InitVar, dataclass
from typing import Any
from warnings import warn

from ..checks import require_flag, require_functions, require_not_negative, require_positive
from ..errors import InputError
from ..integrators import INTEGRATORS, find_integrator
from ..integrators.integrator import Integrator


def _require_tolerance(name: str, value: Any) -> float:
    return math.inf if value == math.inf else require_positive(name, value)


_CHECKS: dict[str, Callable[[str, Any], Any]] = {
    "stepSize": require_positive,
    "stabilizationRate": require_positive,
    "stepConstant": require_positive,
    "stepSafety": require_positive,
    "massScaling": require_not_negative,
    "startTolerance": require_positive,
    "allowUnstableStep": require_flag,
    "adaptiveStep": require_flag,
    "rejectSteps": require_flag,
    "energyTolerance": _require_tolerance,
    "dependsOnTimeOnly": require_functions,
}
_OPTIONAL = ("stepSize", "stepSafety", "massScaling")
SAY_OF_TIME = "set ExplicitSettings(dependsOnTimeOnly=[function])"


@dataclass(frozen=True)
class ExplicitSettings:
    """How SolveExplicit integrates.

    Args:
        integrator: 'RATTLE', 'RK4' or the paper's 'Zhai', with its default parameters; or the scheme with
            parameters of your own, such as Zhai(psi=0, phi=0, corrector=True).
        scheme: deprecated: give the scheme with its parameters as the integrator.
        stepSize: upper bound of the integrator's step [s]; the step used divides the time between two
            outputs. None: chosen by accuracy, see `massScaling`; Zhai and RK4: the largest safe one.
        stabilizationRate: zeta of Eqs. (24)-(28) [1/s]; RATTLE does not need it.
        stepConstant: C of Eq. (37), for stepSize = None [-].
        stepSafety: share of the stability limit at the start that stepSize = None uses at most [-]. None:
            0.95 for cables alone, 0.7 where bodies on cables may pull them tighter in motion.
        massScaling: theta; the mass matrix becomes M + theta h^2 K with the constant bending stiffness K,
            a trapezoidal-like treatment of bending without Newton iterations. Above 1/4, bending no
            longer bounds the step; 0.3 leaves a margin for the tension. Vibrations faster than the step
            are then not resolved. Order 2 is kept. None: 0 with a stepSize; without one, RATTLE takes 0.3,
            and up to 0.55 among bodies, where bending would bound a step that is short enough for the
            motion.
        startTolerance: largest violation of a constraint by the initial state: of values [-, m] and,
            relative to the speed, of rates. Up to it the state is projected onto the constraints; above it
            coordinates are refused, and velocities projected with a warning, as by impulses at supports and
            joints.
        allowUnstableStep: warn, rather than refuse, if stepSize is above the stability limit.
        adaptiveStep: between two outputs, take as many equal steps as the present largest frequency of
            cables, bodies and springs asks for, so that a cable that straightens or is pulled tight, and a
            spring that stiffens, stay within their stability limit; stepSize is then an upper bound, and so
            is the limit with all contacts closed that are open at the start. Not with a massScaling. Beside
            first order states, such as pressures of oil, automatic steps do so by themselves.
        rejectSteps: take steps that go wrong again, with a quarter of the step and less, from the state
            before them. False: they end the run, as in studies of stability limits.
        energyTolerance: energy that a run may have beyond the work done on it, as a share of the energy of
            its motion (largest kinetic energy plus range of the elastic energy so far) [-]; among bodies ten
            times as much. A run with more of it is warned of. Steps that make so much at once are rejected,
            and so are those in which the work of Exudyn's items is known no better. Zhai and RK4, which gain
            energy by themselves, end at 30 times as much. math.inf: the energy is not looked at.
        dependsOnTimeOnly: list of those user functions of loads and constraints that depend on the time
            alone, or True for all, False for none. They are asked ahead of time, so that a run takes many
            steps in one compiled call. None: those of which it can be seen from their code.
    """

    integrator: Any = "RATTLE"
    scheme: InitVar[Any] = None
    stepSize: float | None = None
    stabilizationRate: float = 100.0
    stepConstant: float = 0.7
    stepSafety: float | None = None
    massScaling: float | None = None
    startTolerance: float = 1e-6
    allowUnstableStep: bool = False
    adaptiveStep: bool = False
    rejectSteps: bool = True
    energyTolerance: float = 0.003
    dependsOnTimeOnly: bool | Sequence[Callable[..., Any]] | None = None

    def __post_init__(self, scheme: Any) -> None:
        """Check all of them.

        Raises:
            InputError: unknown integrator, scheme of another integrator, number out of range.
        """
        if scheme is not None:
            self._take_scheme(scheme)
        _ = self.method
        for name, require in _CHECKS.items():
            if getattr(self, name) is not None or name not in _OPTIONAL:
                object.__setattr__(self, name, require(name, getattr(self, name)))
        if self.stepSafety is not None and self.stepSafety > 1.0:
            raise InputError(f"stepSafety = {self.stepSafety!r}: must be at most 1, the stability limit.")
        if self.massScaling and self.adaptiveStep:
            raise InputError(
                f"massScaling = {self.massScaling!r} with adaptiveStep: the scaled mass belongs to one step "
                "size, and bending does not bound the step then; leave one of them out."
            )

    def _take_scheme(self, scheme: Any) -> None:
        """Deprecated: parameters beside the name of their integrator; until the release after 0.1."""
        integrator = find_integrator(self.integrator)
        if not isinstance(scheme, integrator.scheme):
            name = integrator.scheme.__name__
            raise InputError(f"scheme = {scheme!r}: integrator '{self.integrator}' takes {name}(...).")
        message = f"scheme is deprecated: set ExplicitSettings(integrator={scheme!r})."
        warn(message, DeprecationWarning, stacklevel=4)
        object.__setattr__(self, "integrator", scheme)

    @property
    def _integrator(self) -> Integrator:
        found = [one for one in INTEGRATORS.values() if isinstance(self.integrator, one.scheme)]
        return found[0] if found else find_integrator(self.integrator)

    @property
    def method(self) -> tuple[Integrator, Any]:
        """The integrator, and the parameters of its scheme: those given, or its defaults."""
        integrator = self._integrator
        given = self.integrator if isinstance(self.integrator, integrator.scheme) else integrator.scheme()
        return integrator, integrator.checked(given)

    @property
    def integratorName(self) -> str:
        """What the integrator is called."""
        return self._integrator.name
