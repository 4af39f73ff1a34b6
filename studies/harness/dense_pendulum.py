"""The pendulum as dense matrices, so that nodal constraints can be left out and masses lumped.

The package eliminates the nodal constraints node by node and has no such switches. Here the same constraints
and matrices are solved densely, in plain Python: for errors, not for times.
"""

from typing import Any, NamedTuple

import numpy as np

from exudyn_inext import RungeKutta4
from reference_models.model import SENSOR_PERIOD
from reference_models.scenes import load_scene
from reference_models.trajectory import Array, Trajectory
from studies.harness import Row, inner
from studies.harness.reference import distance_to_reference, from_data
from studies.stability.motion import GRAVITY, Equilibrium, straight

NODAL = "nodal inextensibility"
ZETA = 100.0  # [1/s]
SUBSTEPS = {4: 8, 8: 30}  # of a sensor's period, within the limit of the smallest mass
VARIANTS = {
    "as in the package": {"nodal": True, "lumped": False},
    "without nodal constraints": {"nodal": False, "lumped": False},
    "lumped mass": {"nodal": True, "lumped": True},
}


class DenseSystem(NamedTuple):
    """mass, stiffness: (n_dof, n_dof).   rows: of the constraints, that act.   free: (n_dof,) indices."""

    mass: Array
    stiffness: Array
    constraints: Any
    rows: Array
    free: Array
    shape: tuple[int, ...]


@inner.index_reduced_rates.register(DenseSystem)
def dense_rates(system, external, q, v, acceleration, rate):  # type: ignore[no-untyped-def]
    """Eq. (30), by the dense saddle-point matrix (29)."""
    free = system.free
    position, speed = q.reshape(system.shape), v.reshape(system.shape)
    c, own = system.constraints, system.rows
    value, speed_of, gamma = (
        c.value(position)[own],
        c.rate(position, speed)[own],
        c.gamma(position, speed)[own],
    )
    jacobian = c.jacobian(position).toarray()[own][:, free]
    size, rows = len(free), len(value)
    matrix = np.zeros((size + rows, size + rows))
    matrix[:size, :size] = system.mass[np.ix_(free, free)]
    matrix[:size, size:], matrix[size:, :size] = jacobian.T, jacobian
    right = np.zeros((size + rows, 2))
    right[:size, 0] = (external - system.stiffness @ q)[free]
    right[size:, 0] = gamma - ZETA * speed_of
    right[size:, 1] = -ZETA * value - speed_of
    solution = np.linalg.solve(matrix, right)
    acceleration[:] = 0.0
    rate[:] = v
    acceleration[free] = solution[:size, 0]
    rate[free] += solution[:size, 1]


def dense_cases(quick: bool) -> list[Row]:
    """The planar pendulum."""
    numbers = (4,) if quick else (4, 8)
    motion = 0.3 if quick else load_scene("planar_pendulum").end_time
    return [
        {"kind": "dense", "label": label, "scene": "planar_pendulum", "elements": number, "motion": motion}
        for number in numbers
        for label in VARIANTS
    ]


def run_dense(case: Row) -> Row:
    """Largest distance of the tip to the reference, and the worst stretch of a slope at a node."""
    start = straight(case["elements"], GRAVITY)
    system = _system(start, **VARIANTS[case["label"]])
    integrator, substeps = inner.find_integrator("RK4"), SUBSTEPS[case["elements"]]
    take_step = inner.plain(inner.advance.dispatch(RungeKutta4))
    begin = inner.plain(integrator.start)
    external = start.external.ravel()
    state = integrator.allocate(external.size, external.size)
    state.q[:] = start.q.ravel()
    begin(system, external, state)
    loads = inner.no_loads(external.size, len(integrator.stages))._replace(constant=external)
    times, tips = [0.0], [start.q[-1, 0]]
    stretch, q = 0.0, state.q.reshape(start.q.shape)
    while times[-1] < case["motion"] - 0.5 * SENSOR_PERIOD:
        for _ in range(substeps):
            take_step(
                RungeKutta4(), system, loads, state, SENSOR_PERIOD / substeps, 1, np.zeros((1, 3, q.size))
            )
        if not np.isfinite(state.q).all():
            return {"error": None, "stretch": None, "outcome": f"diverged at t = {times[-1]:.3g} s"}
        times.append(SENSOR_PERIOD * len(times))
        tips.append(q[-1, 0].copy())
        stretch = max(stretch, float(np.abs(np.linalg.norm(q[:, 1], axis=1) - 1.0).max()))
    path = Trajectory(np.array(times), np.column_stack([np.array(tips), np.zeros(len(tips))]))
    reference = from_data(load_scene("planar_pendulum"))
    error = distance_to_reference(path, reference.trajectory).maximum
    return {"error": error, "stretch": stretch, "uncertainty": reference.uncertainty, "outcome": "ok"}


def _system(start: Equilibrium, nodal: bool, lumped: bool) -> DenseSystem:
    cable = start.cable
    mass = cable.section.mass_per_length * inner.form_of_cable(cable, inner.mass_matrix).toarray()
    if lumped:  # half an element's mass at each node, and the consistent matrix's diagonal for the slopes
        diagonal = np.diag(mass).reshape(start.q.shape).copy()
        x = np.zeros(start.q.shape)
        x[:, 0, 0] = 1.0  # a rigid translation: row sums over positions alone
        diagonal[:, 0] = (mass @ x.ravel()).reshape(x.shape)[:, 0, :1]
        mass = np.diag(diagonal.ravel())
    stiffness = cable.section.bending_stiffness * inner.form_of_cable(cable, inner.stiffness_matrix).toarray()
    constraints, kinds = inner.constraints_of_cable(cable), ["length", NODAL] if nodal else ["length"]
    rows = np.concatenate([np.arange(constraints.number)[constraints.rows[kind]] for kind in kinds])
    held = np.repeat(cable.fixed[:, :, None], 2, axis=2).ravel()
    return DenseSystem(mass, stiffness, constraints, rows, np.flatnonzero(~held), start.q.shape)
