"""Which joints make knots, and how their forces follow from those on the points."""

from exudyn_inext.multibody.knots import GROUND, NONE, Tie, find_knots


def point(owner):
    return owner, "end"


def knots(*pairs, taken=()):
    ties = [Tie(row, (point(one), point(other))) for row, (one, other) in enumerate(pairs)]
    return list(find_knots(ties, {point(owner) for owner in taken}))


def test_two_points_are_no_knot():
    assert knots((0, 1)) == []
    assert knots((0, 1), (2, 3)) == []


def test_a_star_and_a_chain_are_knots():
    for pairs in ([(0, 1), (0, 2), (0, 3)], [(0, 1), (2, 1), (2, 3)]):
        (knot,) = knots(*pairs)
        assert sorted(member.owner for member in knot) == [0, 1, 2, 3]
        assert (knot[0].row, knot[0].parent) == (NONE, NONE)
        for member in knot[1:]:
            one, other = pairs[member.row]
            assert (member.owner == other) == (member.sign == 1)
            assert knot[member.parent].owner == (one if member.sign == 1 else other)


def test_a_knot_on_the_ground_has_no_place_to_find():
    (knot,) = knots((0, 1), (1, 2), (GROUND, 2))
    assert [member.owner for member in knot] == [2, 1, 0]
    assert [member.parent for member in knot] == [NONE, 0, 1]
    assert [member.row for member in knot] == [2, 1, 0]
    assert [member.sign for member in knot] == [1, -1, -1]


def test_the_ground_does_not_join_knots():
    found = knots((GROUND, 0), (0, 1), (0, 2), (GROUND, 3), (3, 4), (3, 5))
    assert [sorted(member.owner for member in knot) for knot in found] == [[0, 1, 2], [3, 4, 5]]


def test_loops_and_points_that_are_held_otherwise_are_no_knots():
    assert knots((0, 1), (1, 2), (2, 0)) == []
    assert knots((0, 1), (1, 2), (GROUND, 0), (GROUND, 2)) == []
    assert knots((0, 1), (1, 2), taken=[1]) == []
    ties = [Tie(0, ((0, "a"), (1, "a"))), Tie(1, ((1, "a"), (0, "b")))]
    assert list(find_knots(ties, set())) == []  # two points of one owner
