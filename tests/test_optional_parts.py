"""Parts of kernels that many cables do not have, with the compiler and without it."""

import numpy as np
import pytest

from exudyn_inext.arrays import record_type
from exudyn_inext.compiled import kernel, optional

pytestmark = pytest.mark.kernel


@optional("table")
def add_rows(axes, nodes, elements, amount):
    """Adds to the nodes."""
    for k in range(len(nodes)):
        nodes[k] += amount * elements[0].table.shape[0]


@kernel
def add_twice(axes, nodes, elements, amount):
    """As compiled code calls it."""
    add_rows(axes, nodes, elements, amount)
    add_rows(axes, nodes, elements, amount)


@pytest.mark.parametrize("rows", [0, 3])
def test_they_act_where_the_records_have_their_field(rows):
    elements = np.zeros(2, record_type([("table", float, (rows, 2)), ("other", float)]))
    nodes = np.zeros(4)
    add_twice((0, 1), nodes, elements, 0.5)
    assert (nodes == rows).all()
    add_rows((0, 1), nodes, elements, 1.0)
    assert (nodes == 2 * rows).all()


def test_where_the_field_is_empty_they_are_not_even_compiled():
    @optional("table")
    def impossible(axes, nodes, elements):
        nodes.no_such_attribute()

    @kernel
    def call(axes, nodes, elements):
        impossible(axes, nodes, elements)

    elements = np.zeros(1, record_type([("table", float, (0, 2))]))
    call((0, 1), np.zeros(1), elements)


def test_they_keep_their_names():
    assert (add_rows.__name__, add_rows.__doc__) == ("add_rows", "Adds to the nodes.")
