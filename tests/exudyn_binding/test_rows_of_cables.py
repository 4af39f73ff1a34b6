"""Which cables go on in one another."""

import numpy as np
import pytest

from exudyn_inext import CreateInextensibleCable, InextensibleCable
from exudyn_inext.exudyn_binding.scene import read_scene
from exudyn_inext.run.rows_of_cables import rows_of


@pytest.fixture
def pieces(new_mbs):
    """(x of ends, numbers of pieces whose last nodes they begin at, arguments) ... -> rows."""

    def rows(*given):
        mbs, made = new_mbs(), []
        for k, (ends, begins_at, more) in enumerate(given):
            line = {f"position{end}": [x, 0, 0] for end, x in zip(("Start", "End"), ends, strict=True)}
            node = {} if begins_at is None else {"nodeNumberStart": made[begins_at]["nodes"][-1]}
            section = InextensibleCable(massPerLength=4.0**k, bendingStiffness=1.0)
            made.append(
                CreateInextensibleCable(mbs, **line, numberOfElements=2, beamTemplate=section, **node, **more)
            )
        mbs.Assemble()
        return rows_of(read_scene(mbs).cables)

    return rows


def test_a_row_has_the_elements_of_all_pieces_in_their_order(pieces):
    rows = pieces(([0, 2], None, {}), ([2, 6], 0, {}), ([6, 7], 1, {}))
    for k, row in enumerate(rows):
        np.testing.assert_allclose(row.lengths, [1, 1, 2, 2, 0.5, 0.5])
        np.testing.assert_allclose(row.times, [1, 1, 8, 8, 1, 1])  # l^2 sqrt(rho_A / EI)
        assert row.own == slice(2 * k, 2 * k + 2)


@pytest.mark.parametrize(
    "more", [[([2, 6], 0, {"shareSlopeStart": False})], [([2, 6], 0, {}), ([2, 3], 0, {})]]
)
def test_hinges_and_forks_end_a_row(pieces, more):
    assert [len(row.lengths) for row in pieces(([0, 2], None, {}), *more)] == [2] * (1 + len(more))
