"""What is done before a run grows with the number of cables, and no faster."""

import sys

import pytest

from exudyn_inext import CreateCompanionCables, InextensibleCable

PINNED = [True, True, False, False]


def calls(action):
    """How many calls of functions, of Python and of C, an action takes, and what it returns."""
    count = 0

    def look(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(look)
    try:
        action()
    finally:
        sys.setprofile(None)
    return count


@pytest.fixture
def short_cables(new_mbs, add_cable):
    """number -> a system of that many short cables, and what their creation returned."""

    def build(number):
        mbs = new_mbs()
        template = InextensibleCable(0.1, 1e-3)
        line = {"numberOfElements": 2, "beamTemplate": template, "groundConstraintsStart": PINNED}
        return mbs, [
            add_cable(mbs, positionStart=[0, 0.1 * k, 0], positionEnd=[1, 0.1 * k, 0], **line)
            for k in range(number)
        ]

    return build


def test_the_cost_of_a_start_grows_as_the_number_of_cables(short_cables, solve):
    found = []
    for number in (5, 50, 200):  # the first one compiles
        mbs, _ = short_cables(number)
        mbs.Assemble()
        found.append(calls(lambda mbs=mbs: solve(mbs, 1e-3, stepSize=1e-3)))
    assert found[2] < 4.2 * found[1]


def test_the_cost_of_companions_grows_as_the_number_of_cables(short_cables):
    found = []
    for number in (50, 200):
        mbs, cables = short_cables(number)
        found.append(calls(lambda mbs=mbs, cables=cables: [CreateCompanionCables(mbs, c) for c in cables]))
    assert found[1] < 4.2 * found[0]


def test_companions_of_a_system_that_is_built_anew_are_its_own(mbs, add_cable):
    for elements in (2, 5):
        mbs.Reset()
        cable = add_cable(mbs, numberOfElements=elements)
        first = CreateCompanionCables(mbs, cable)
        assert CreateCompanionCables(mbs, cable) == first
        assert [mbs.GetObject(k)["objectType"] for k in first] == ["ANCFCable2D"] * elements
