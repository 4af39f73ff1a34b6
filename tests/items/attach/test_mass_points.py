"""Exudyn's mass points on a cable's own nodes: as on those of native cables."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodePosition,
    MassPoint,
    MassPoint2D,
    SpringDamper,
)

from exudyn_inext import CableForces, SceneError, SolveEquilibrium
from tests.exudyn_binding.items import SECTION, either_cable, solve_native, trajectory

END = 0.6  # [s]
MIDDLE, TIP = 0.02, 0.03  # [kg], the first one without weight


def hang_weights(mbs, nodes, dimension):
    """Number of the weight of the one at the tip."""
    kind = MassPoint if dimension == 3 else MassPoint2D
    mbs.AddObject(kind(mass=MIDDLE, nodeNumber=nodes[len(nodes) // 2]))
    tip = mbs.AddObject(kind(mass=TIP, nodeNumber=nodes[-1]))
    marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=tip))
    return tip, mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, -9.81, 0]))


def spring_below(mbs, marker):
    """A body on a spring, below the tip."""
    body = mbs.CreateMassPoint(mass=0.1, referencePosition=[1.8, -0.3, 0], gravity=[0, -9.81, 0])
    pair = [marker, mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))]
    mbs.AddObject(SpringDamper(markerNumbers=pair, referenceLength=0.3, stiffness=50.0, name="spring"))


def hang_alone(mbs, nodes, dimension):
    hang_weights(mbs, nodes, dimension)


def hang_with_a_body(mbs, nodes, dimension):
    tip, _ = hang_weights(mbs, nodes, dimension)
    spring_below(mbs, mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[-1])))
    place = mbs.AddMarker(MarkerBodyPosition(bodyNumber=tip))
    mbs.AddLoad(LoadForceVector(markerNumber=place, loadVector=[0.1, 0, 0]))


def hang_and_pull(mbs, nodes, dimension):
    """The weight of the tip changes with time."""
    _, load = hang_weights(mbs, nodes, dimension)
    mbs.SetLoadParameter(load, "loadVectorUserFunction", lambda mbs, t, g: [20.0 * t, g[1], 0.0])


def hang_and_change(mbs, nodes, dimension):
    """The weight of the tip changes between steps."""
    _, load = hang_weights(mbs, nodes, dimension)

    def change(mbs, t):
        mbs.SetLoadParameter(load, "loadVector", [0, -9.81 - 20.0 * (t > 0.2), 0])
        return True

    mbs.SetPreStepUserFunction(change)


SCENES = [
    (hang_alone, 2),
    (hang_alone, 3),
    (hang_and_pull, 2),
    (hang_with_a_body, 2),
    (hang_and_change, 2),
]


def add_line(mbs, native, dimension=2):
    pinned = [True] * dimension + [False] * dimension
    line = {"positionStart": [0, 0, 0], "positionEnd": [1.8, 0, 0], "gravity": [0, -9.81, 0]}
    line |= {"groundConstraintsStart": pinned, "numberOfElements": 20 if native else 10}
    return either_cable(mbs, native, dimension, SECTION, 8e4, **line)[0]


@pytest.mark.parametrize(("hang", "dimension"), SCENES)
def test_a_cable_with_mass_points_moves_as_a_native_one(new_mbs, add_sensor, solve, hang, dimension):
    paths = []
    for native in (False, True):
        mbs = new_mbs()
        nodes = add_line(mbs, native, dimension)
        hang(mbs, nodes, dimension)
        sensor = add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        if native:
            solve_native(mbs, END, 2e-3)
        else:
            solve(mbs, END, steps=300)
        paths.append(trajectory(mbs, sensor)[:, 1:])
    size = np.ptp(paths[1][:, 1])
    np.testing.assert_allclose(paths[0][::10], paths[1][::10], atol=5e-3 * size)


def test_a_mass_that_changes_between_steps_moves_as_in_two_native_runs(new_mbs, solve):
    """In one run, Exudyn's solvers keep constant masses."""
    ours, native = new_mbs(), new_mbs()
    ends = []
    for mbs in (ours, native):
        nodes = add_line(mbs, mbs is native)
        tip, _ = hang_weights(mbs, nodes, 2)
        mbs.Assemble()
        if mbs is ours:
            mbs.SetPreStepUserFunction(double_after(0.4, tip))
            solve(mbs, 0.5, steps=250)
        else:
            solve_native(mbs, 0.4, 2e-3)
            start_again(mbs)
            mbs.SetObjectParameter(tip, "mass", 2.0 * TIP)
            solve_native(mbs, 0.1, 2e-3)
        ends.append(mbs.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position))
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-3)


def double_after(time, body):
    """A pre-step function that sets the mass of a body, which is TIP before."""

    def change(mbs, t):
        mbs.SetObjectParameter(body, "mass", TIP * (1.0 + (t > time + 1e-9)))
        return True

    return change


def start_again(mbs):
    """From the present state."""
    initial, data = exudyn.ConfigurationType.Initial, mbs.systemData
    data.SetODE2Coordinates(data.GetODE2Coordinates(), initial)
    data.SetODE2Coordinates_t(data.GetODE2Coordinates_t(), initial)


def test_a_hanging_cable_carries_the_weights_on_its_nodes(mbs, add_pendulum):
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0], numberOfElements=4)
    hang_weights(mbs, cable["nodes"], 2)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    forces = CableForces(mbs, cable, [0.0, 0.4, 1.0, 1.7])
    carried = SECTION["massPerLength"] * (1.8 - forces["arcLength"]) + TIP
    np.testing.assert_allclose(forces["tension"], 9.81 * carried, rtol=1e-8)


def test_a_spring_between_a_mass_point_and_a_body_is_refused_as_exudyn_loads_the_slopes(
    mbs, add_pendulum, solve
):
    nodes = add_pendulum(mbs)["nodes"]
    tip, _ = hang_weights(mbs, nodes, 2)
    spring_below(mbs, mbs.AddMarker(MarkerBodyPosition(bodyNumber=tip)))
    mbs.Assemble()
    with pytest.raises(SceneError, match=rf"'spring'.*MarkerNodePosition\(nodeNumber={int(nodes[-1])}\)"):
        solve(mbs)
