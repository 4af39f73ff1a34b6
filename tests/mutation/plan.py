"""Which mutants are made, and which tests are to notice those of a module."""

from collections.abc import Sequence
from pathlib import PurePath

_BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Mul_Add", "Div_Mul", "Pow_Mul", "FloorDiv_Mul", "Mod_Add")
_COMPARISONS = ("Eq", "NotEq", "Lt", "LtE", "Gt", "GtE")
_IDENTITIES = ("Is_IsNot", "IsNot_Is")

# Left out: decorators (hints to the compiler, or without them nothing can be imported) and operators that
# numbers do not have (bits, shifts): whatever runs the line would notice those.
OPERATORS = [
    f"core/{name}"
    for name in (
        "NumberReplacer",
        *(f"ReplaceBinaryOperator_{pair}" for pair in _BINARY),
        *(f"ReplaceComparisonOperator_{a}_{b}" for a in _COMPARISONS for b in _COMPARISONS if a != b),
        *(f"ReplaceComparisonOperator_{pair}" for pair in _IDENTITIES),
        "ReplaceUnaryOperator_Delete_USub",
        "ReplaceUnaryOperator_Delete_Not",
        "ReplaceAndWithOr",
        "ReplaceOrWithAnd",
        "ReplaceBreakWithContinue",
        "ReplaceContinueWithBreak",
        "ReplaceTrueWithFalse",
        "ReplaceFalseWithTrue",
        "AddNot",
        "ZeroIterationForLoop",
    )
]

_ELEMENT = ("element/test_shape_functions.py", "element/test_element_matrices.py", "element/test_bending.py")
_CHAIN = (
    "cable/test_motion.py",
    "cable/test_cable.py",
    "cable/test_violations.py",
    "cable/test_attached.py",
    "cable/test_structured_solve.py",
    "cable/test_linked_cable.py",
    "cable/test_damped_chain.py",
    "cable/test_sparse_forms.py",
)
_FREQUENCIES = (
    "cable/test_small_vibrations.py",
    "cable/test_ring_frequencies.py",
    "cable/test_largest_frequency.py",
)
_ROWS = ("cable/test_penalty_mass.py", "contracts/test_every_constraint.py")

# What is run for a module, most telling first; a survivor may be noticed by tests that are not run.
_TESTS: dict[str, Sequence[str]] = {
    "shape_functions": _ELEMENT[:2],
    "inertia": _ELEMENT,
    "bending": (*_ELEMENT, "cable/test_structured_solve.py"),
    "bending_damping": ("element/test_bending_damping.py", "cable/test_damped_chain.py"),
    "natural_curvature": ("element/test_natural_curvature.py",),
    "drag": ("element/test_drag.py", "cable/test_attached.py"),
    "external_force": ("loads/test_loads.py", "element/test_element_matrices.py"),
    "forms": (*_ELEMENT, "cable/test_structured_solve.py"),
    "attached": (
        "cable/test_cable.py",
        "cable/test_attached.py",
        "cable/test_section_forces.py",
        "loads/test_loads.py",
    ),
    "attached_forces": ("cable/test_section_forces.py", "cable/test_attached.py"),
    "section_forces": ("cable/test_section_forces.py",),
    "constraint_rows": _ROWS,
    "penalty_mass": _ROWS,
    "frequency": _FREQUENCIES,
    "linear_response": _FREQUENCIES,
    "links": (
        "cable/test_violations.py",
        "cable/test_linked_cable.py",
        *_ROWS[:1],
        "cable/test_ring_frequencies.py",
    ),
    "linked_cable": ("cable/test_linked_cable.py", *_FREQUENCIES),
    "energy": ("cable/test_energy.py",),
    "cable": (
        "cable/test_cable.py",
        "cable/test_motion.py",
        "cable/test_violations.py",
        "element/test_element_matrices.py",
    ),
    "link": ("cable/test_cable.py", "cable/test_linked_cable.py", "constraints", *_ROWS),
    "factorisation": (*_CHAIN[:6], *_FREQUENCIES),
    "saddle_point": (*_CHAIN[:6], *_FREQUENCIES),
}
_OTHERS = (*(name for name in _CHAIN if "linked" not in name), "loads/test_loads.py", _FREQUENCIES[0])


def tests_of(module: str) -> list[str]:
    """The tests that are run for the mutants of a module."""
    return [f"tests/{name}" for name in _TESTS.get(PurePath(module).stem, _OTHERS)]


SLOW = "20- or 11- or hessian or (largest_frequency and (-3 or 3-))"
"""Names of tests that are left out: the same as others, of longer chains."""
