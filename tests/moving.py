"""Cables on their constraints, and their motion by any integrator, without Exudyn."""

from dataclasses import replace

import numpy as np

from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from tests.cables import dense_constraints, dense_mass


def move(state, h, steps, every=1, name="RATTLE", zeta=0.0, mass_scaling=0.0, lag=0.0):
    """(steps / every, 3, n, 2, dim) q, v, a of a cable under constant forces, its anchors at rest."""
    system = cable_system(state.cable, zeta, ImplicitBending(mass_scaling, lag))
    return move_system(system, state, h, steps, every, name)


def move_system(system, state, h, steps, every=1, name="RATTLE"):
    """The same with a system of `state.cable` that is there already."""
    integrator, inputs = INTEGRATORS[name], state.inputs
    factor = np.zeros((steps, len(integrator.stages), 0))
    loads = LoadHistory(inputs, np.zeros((0, inputs.size)), factor)
    memory = integrator.allocate(state.q.size, inputs.size)
    memory.q[:], memory.v[:] = state.q.ravel(), state.v.ravel()
    integrator.start(system, inputs, memory)
    history = np.zeros((steps // every, 3, state.q.size))
    record(integrator, integrator.scheme(), system, loads, memory, h, every, history)
    return history.reshape(-1, 3, *state.q.shape)


def on_constraints(state):
    """The same cable with its reference at q, slopes made unit, and v moved to the nearest admissible one."""
    q = state.q.copy()
    q[:, 1] /= np.linalg.norm(q[:, 1], axis=1)[:, None]
    cable = replace(state.cable, reference=q)
    jacobian = dense_constraints(cable, q, state.v, state.time).jacobian
    response = np.linalg.solve(dense_mass(cable), jacobian.T)
    multipliers = np.linalg.lstsq(jacobian @ response, jacobian @ state.v.ravel(), rcond=1e-12)[0]
    v = state.v - (response @ multipliers).reshape(q.shape)
    return replace(state, cable=cable, q=q, v=v)
