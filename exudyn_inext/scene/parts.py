"""What the coupling asks of a part besides the protocols of `system`: its response to joint forces."""

from functools import singledispatch

from ..cable.linear_response import respond
from ..called_system import called
from ..compiled import kernel


@singledispatch
def respond_to_rows(system, first, width, dof, jacobian, response):
    """response_r = A^-1 J_r^T: acceleration of a part, on its own constraints, under a unit joint force.

    Args:
        system: just evaluated by a protocol of `system`, so that it is factorised.
        first, width: (rows,) where each row begins in `jacobian` and `response`, and how long it is.
        dof: (rows,) the first coordinate in the system of the cable or body that the row is on.
        jacobian, response: (sum of the widths of all parts,); output.
    """
    _respond_with_cables(called(system, respond), first, width, dof, jacobian, response)


@kernel
def _respond_with_cables(system, first, width, dof, jacobian, response):
    for row in range(len(first)):
        begin, end = first[row], first[row] + width[row]
        respond(system, dof[row], jacobian[begin:end], response[begin:end])
