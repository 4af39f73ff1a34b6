"""Section and discretisation of an inextensible cable, in the user's terms."""

from dataclasses import dataclass
from numbers import Number
from typing import Any

from exudyn.itemInterface import ObjectALEANCFCable2D, ObjectANCFCable, ObjectANCFCable2D

from ..cable.cable import CurvatureMeasure, Section
from ..checks import (
    as_number,
    require_choice,
    require_finite,
    require_integer,
    require_not_negative,
    require_positive,
)
from ..errors import InputError


@dataclass(frozen=True)
class InextensibleCable:
    """Properties of a cable, inextensible or with axial stiffness; takes the place of a native beam template.

    Args:
        massPerLength: rho_A [kg/m].
        bendingStiffness: EI [N m^2].
        curvatureMeasure: 'secondDerivative' (kappa^2 = |r_xx|^2, cheaper and more accurate) or
            'product' (kappa^2 = |r_x|^2 |r_xx|^2, the paper's Eq. (4)).
        bendingDamping: D of the bending moment D kappa_t (Kelvin-Voigt) [N m^2 s], as in native cables.
        referenceCurvature: natural curvature [1/m] of a planar cable, positive if it turns to the left.
        numberOfLengthConstraints: n_bar of Eq. (19), 0 to the number of elements; None: one per element.
        axialStiffness: EA of the tension EA (|r_x| - 1 - referenceAxialStrain) [N]; None: inextensible. Such
            cables take neither curvatureMeasure='product' nor numberOfLengthConstraints.
        axialDamping: of the tension that the rate of the strain adds [N s].
        referenceAxialStrain: strain of the stress-free cable [-].
        strainIsRelativeToReference: share of the given shape's curvature and strain that is stress-free:
            0 none, 1 all of it. Not of shapes that are curved in space.

    Example:
        InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866)
    """

    massPerLength: float
    bendingStiffness: float
    curvatureMeasure: str = CurvatureMeasure.SECOND_DERIVATIVE.value
    numberOfLengthConstraints: int | None = None
    bendingDamping: float = 0.0
    referenceCurvature: float = 0.0
    axialStiffness: float | None = None
    axialDamping: float = 0.0
    referenceAxialStrain: float = 0.0
    strainIsRelativeToReference: float = 0.0

    @classmethod
    def from_template(cls, template: Any, extensible: bool = False) -> "InextensibleCable":
        """`template` itself, or the counterpart of a native ANCF cable template.

        Without `extensible` the axial stiffness of a native template is left out. Its user functions are
        taken by `items.attach.user_forces`.

        Raises:
            InputError: not a cable template, or one that begins strained without `extensible`.
        """
        if isinstance(template, cls):
            return template
        if isinstance(template, ObjectALEANCFCable2D):
            raise InputError(
                "beamTemplate = ObjectALEANCFCable2D: elements through which the cable moves (ALE) have no "
                "counterpart; move them by mbs.SolveDynamic, or give an ObjectANCFCable2D, whose nodes go "
                "with the cable, and leave out the ALE node and its constraints."
            )
        if not isinstance(template, ObjectANCFCable | ObjectANCFCable2D):
            is_item = hasattr(template, "visualization")
            given = type(template).__name__ if is_item else repr(template)
            raise InputError(
                f"beamTemplate = {given}: must be an InextensibleCable, or an ObjectANCFCable2D or "
                "ObjectANCFCable whose massPerLength and bendingStiffness are taken over."
            )
        axial = ("axialStiffness", "axialDamping", "referenceAxialStrain") if extensible else ()
        strain = _native_value(template, "referenceAxialStrain")
        if _is_set(strain) and not extensible:
            raise InputError(
                f"beamTemplate.referenceAxialStrain = {strain!r}: only cables that stretch begin "
                "strained; give extensible=True, which takes axialStiffness over, too, or set it to zero."
            )
        bending = ("bendingDamping", "referenceCurvature", "strainIsRelativeToReference")
        names = ("massPerLength", "bendingStiffness", *bending, *axial)
        return cls(**{name: _native_value(template, name) for name in names})

    def section(self, dimension: int) -> Section:
        """Checked constants of the cross-section of a cable in that many dimensions.

        Raises:
            InputError: a number out of range, or natural curvature in space.
        """
        curvature = require_finite("referenceCurvature", self.referenceCurvature, "1/m")
        if curvature and dimension == 3:
            raise InputError(
                f"referenceCurvature = {curvature!r} in 3D: which way the section faces is not modelled; set "
                "it to zero, or use dimension=2."
            )
        if as_number(self.bendingStiffness) == 0.0:
            raise InputError(
                f"bendingStiffness = {self.bendingStiffness!r}: must be a finite number > 0; give a rope "
                "that hardly resists bending a small one, such as 1e-6 g massPerLength length^3."
            )
        return Section(
            require_positive("massPerLength", self.massPerLength),
            require_positive("bendingStiffness", self.bendingStiffness),
            curvature,
            require_not_negative("bendingDamping", self.bendingDamping),
            *self._axial(),
            require_finite("strainIsRelativeToReference", self.strainIsRelativeToReference),
        )

    def _axial(self) -> tuple[float | None, float, float]:
        """Checked axial stiffness, damping and strain of the stress-free cable."""
        damping = require_not_negative("axialDamping", self.axialDamping)
        strain = require_finite("referenceAxialStrain", self.referenceAxialStrain)
        if self.axialStiffness is None:
            for name, value in (("axialDamping", damping), ("referenceAxialStrain", strain)):
                if value:
                    raise InputError(
                        f"{name} = {value!r} without axialStiffness: an inextensible cable has no axial "
                        "strain; give axialStiffness, too, or leave it out."
                    )
            return None, 0.0, 0.0
        stiffness = require_positive("axialStiffness", self.axialStiffness)
        refused = {
            "curvatureMeasure": self.measure() is not CurvatureMeasure.SECOND_DERIVATIVE,
            "numberOfLengthConstraints": self.numberOfLengthConstraints is not None,
        }
        for name, is_set in refused.items():
            if is_set:
                raise InputError(
                    f"{name} = {getattr(self, name)!r} with axialStiffness = {stiffness!r}: not supported "
                    f"for cables that stretch; leave out {name}, or the axial stiffness."
                )
        if strain <= -1.0:
            raise InputError(
                f"referenceAxialStrain = {strain!r}: must be above -1, where the cable has no length."
            )
        return stiffness, damping, strain

    def measure(self) -> CurvatureMeasure:
        """Checked curvature measure; InputError if it is unknown."""
        known = [measure.value for measure in CurvatureMeasure]
        return CurvatureMeasure(require_choice("curvatureMeasure", self.curvatureMeasure, known))

    def length_constraints(self, number_of_elements: int) -> int:
        """Checked n_bar for a cable of that many elements; InputError if it is not among 0 to that number."""
        number = self.numberOfLengthConstraints
        if number is None:
            return number_of_elements
        name = "numberOfLengthConstraints"
        return require_integer(name, number, 0, number_of_elements, ", the number of elements")


def stiffness_left_out(given: Any, template: InextensibleCable) -> float | None:
    """Axial stiffness of a native template that `template` leaves out [N]; None: there is none."""
    stiffness = None if given is template else _native_value(given, "axialStiffness")
    is_number = isinstance(stiffness, Number) and stiffness > 0.0  # type: ignore[operator]
    return float(stiffness) if is_number and template.axialStiffness is None else None  # type: ignore


def _native_value(template: Any, name: str) -> Any:
    """A property of a native template, also by its name of older versions (`physicsMassPerLength`)."""
    older = getattr(template, f"physics{name[0].upper()}{name[1:]}", None)
    value = getattr(template, name, 0.0) if older is None else older
    return float(value) if isinstance(value, bool) else value


def _is_set(value: Any) -> bool:
    """Whether a property of a native template differs from zero, None and False."""
    return not (value is None or (isinstance(value, Number) and value == 0))
