"""The solve of joints among many parts is that of the dense matrix, with rows named that depend on others."""

import numpy as np
import pytest

from exudyn_inext import RedundantConstraintError
from exudyn_inext.scene.bodies import BodiesSystem, MassBlock
from exudyn_inext.scene.joints import JointBlock, JointSolve

pytestmark = pytest.mark.kernel
SIDE, SIZE = 7, 3  # parts along a side of the net, and coordinates of each


def net(random):
    """Masses, and J of random rows between neighbours in a square mesh."""
    part = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    along, across = ((part[:, :-1], part[:, 1:]), (part[:-1], part[1:]))
    ties = [tie for pair in (along, across) for tie in zip(*(side.flat for side in pair), strict=True)]
    factors = random.standard_normal((len(part.flat), SIZE, SIZE))
    masses = factors @ factors.transpose(0, 2, 1) + np.eye(SIZE)
    jacobian = np.zeros((len(ties), len(masses), SIZE))
    for row, tie in enumerate(random.permutation(ties)):
        jacobian[row, tie] = random.standard_normal((2, SIZE))
    return masses, jacobian


def solve_of(masses, jacobian):
    """Rows of (m, P, k) on P parts with masses (P, k, k)."""
    blocks = []
    for part, mass in enumerate(masses):
        rows = np.flatnonzero(jacobian[:, part].any(axis=1))
        system = BodiesSystem(SIZE, [MassBlock(np.arange(SIZE), mass)])
        blocks.append(JointBlock(system, slice(SIZE * part, SIZE * (part + 1)), rows))
    solve = JointSolve(blocks, [f"joint {row}" for row in range(len(jacobian))])
    for block, part in zip(blocks, range(len(masses)), strict=True):
        block.jacobian[:] = jacobian[block.rows, part]
    return solve


def test_a_net_is_solved_as_by_the_dense_matrix_again_and_again():
    random = np.random.default_rng(5)
    masses, jacobian = net(random)
    solve, inverses = solve_of(masses, jacobian), np.linalg.inv(masses)
    for _ in range(2):
        solve.factorise()
        x, target = random.standard_normal(masses[..., 0].size), random.standard_normal(len(jacobian))
        rows = jacobian.reshape(len(jacobian), -1)
        responses = np.einsum("rpi,pij->rpj", jacobian, inverses).reshape(rows.shape)
        nu = np.linalg.solve(rows @ responses.T, rows @ x - target)
        expected = x - responses.T @ nu
        np.testing.assert_allclose(solve.apply(x, target), nu, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(x, expected, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(solve.times_jacobian(x), target, rtol=1e-10, atol=1e-12)


def test_a_row_that_others_make_up_is_named_wherever_it_is_eliminated():
    """The last row is the sum of two others, which meet on a part."""
    masses, jacobian = net(np.random.default_rng(6))
    one = 17
    other = next(row for row in range(len(jacobian)) if row != one and meets(jacobian[row], jacobian[one]))
    jacobian[-1] = jacobian[one] + jacobian[other]
    with pytest.raises(RedundantConstraintError, match=f"^joint {len(jacobian) - 1}, equation") as said:
        solve_of(masses, jacobian).factorise()
    assert str(said.value).count("joint ") == 1


def meets(row, other):
    return (row.any(axis=1) & other.any(axis=1)).any()
