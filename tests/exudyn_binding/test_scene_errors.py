"""What a function does not deal with, or SolveExplicit cannot start from, is named; mbs stays as it was."""

from functools import partial

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    LoadForceVector,
    LoadTorqueVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    MassPoint,
    NodePoint,
    NodePointGround,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    InextensibleError,
    RedundantConstraintError,
    SceneError,
    SolveEquilibrium,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence


def refused(mbs, solve, contents, message, error=SceneError):
    before = contents(mbs)
    with pytest.raises(error, match=message):
        solve(mbs)
    assert contents(mbs) == before


@pytest.mark.parametrize("solve", [SolveExplicit, SolveEquilibrium], ids=lambda one: one.__name__)
def test_a_system_that_is_not_assembled_is_refused_if_that_is_asked_for(mbs, add_pendulum, solve, contents):
    solve = partial(solve, autoAssemble=False)
    add_pendulum(mbs)
    refused(mbs, solve, contents, r"not assembled: call mbs.Assemble\(\)")
    mbs.Assemble()
    mbs.AddNode(NodePointGround())
    refused(mbs, solve, contents, r"not assembled: call mbs.Assemble\(\)")


def markers(mbs, node):
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
    return [ground, mbs.AddMarker(MarkerNodePosition(nodeNumber=node))]


def rigid_body(mbs, node):
    mbs.CreateRigidBody(inertia=InertiaCuboid(1000, [0.1] * 3), referencePosition=[3, 0, 0])


def spring(mbs, node):
    mbs.AddObject(CartesianSpringDamper(markerNumbers=markers(mbs, node), stiffness=[1] * 3, name="hook"))


def distance_to_a_body(mbs, node):
    body = mbs.AddObject(MassPoint(mass=1, nodeNumber=mbs.AddNode(NodePoint())))
    pair = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)), markers(mbs, node)[1]]
    mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=1, name="rod"))


def offset_constraint(mbs, node):
    ground = mbs.AddNode(NodePointGround())
    pair = [MarkerNodeCoordinate(nodeNumber=n, coordinate=c) for n, c in ((ground, 0), (node, 3))]
    numbers = [mbs.AddMarker(marker) for marker in pair]
    mbs.AddObject(CoordinateConstraint(markerNumbers=numbers, offset=0.1, name="pulled"))


def mass_point(mbs, node):
    foreign = mbs.AddNode(NodePoint(name="elsewhere"))
    mbs.AddObject(MassPoint(mass=1, nodeNumber=foreign))


def foreign_load(mbs, node):
    mass_point(mbs, node)
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node + 3))
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[1, 0, 0], name="push"))


def torque(mbs, node):
    marker = mbs.AddMarker(MarkerNodeRigid(nodeNumber=node))
    mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 1], name="twist"))


FOREIGN = [
    (rigid_body, r"object 3 .*\(RigidBody\)"),
    (spring, r"object 4 'hook' \(ConnectorCartesianSpringDamper\)"),
    (distance_to_a_body, r"object 5 'rod' \(ConnectorDistance\)"),
    (offset_constraint, r"object 3 'pulled' \(ConnectorCoordinate\)"),
    (mass_point, r"\(MassPoint\).*node 7 'elsewhere' \(Point\)"),
    (foreign_load, r"load 0 'push' \(ForceVector\)"),
    (torque, r"load 0 'twist' \(TorqueVector\)"),
]
AT_REST = {  # what statics says; nothing: it finds the equilibrium
    "rigid_body": "nothing connects object .* to the ground",
    "mass_point": "nothing connects object .* to the ground",
    "foreign_load": "nothing connects object .* to the ground",
    "torque": "no stable equilibrium within reach",  # more than the weight can balance
}


@pytest.mark.parametrize(("add", "message"), FOREIGN, ids=lambda value: getattr(value, "__name__", ""))
def test_statics_takes_other_items_and_names_what_nothing_holds(mbs, add_pendulum, contents, add, message):
    cable = add_pendulum(mbs)
    add(mbs, int(cable["nodes"][4]))
    mbs.Assemble()
    said = AT_REST.get(add.__name__)
    if said:
        refused(mbs, SolveEquilibrium, contents, said, InextensibleError)
    else:
        assert SolveEquilibrium(mbs)["success"]


INCONSISTENT = [
    ("initialCoordinates", 0, [0, 0.1, 0, 0], "initial coordinates .*pin .* position y of node 0"),
    ("initialCoordinates", 3, [0.1, 0, 0, 0], "initial coordinates .*length constraint .* 2"),
    ("initialCoordinates", 3, [0, 0, 0.1, 0], "initial coordinates .*nodal .* slope of node 3"),
]
FAST = [
    (0, [0, 0.1, 0, 0], "initial velocities .*pin .* position y of node 0 by 0.1 "),
    (3, [0.1, 0, 0, 0], "initial velocities .*length constraint .* 2 and 3 by 0.2 "),
    (3, [0, 0, 0.1, 0], "initial velocities .*nodal .* slope of node 3 by 0.2 "),
]


@pytest.mark.parametrize(("what", "node", "values", "message"), INCONSISTENT)
def test_inconsistent_initial_values_are_refused(
    mbs, add_pendulum, solve, contents, what, node, values, message
):
    cable = add_pendulum(mbs)
    mbs.SetNodeParameter(cable["nodes"][node], what, values)
    mbs.Assemble()
    refused(mbs, solve, contents, f"{message}.*limit 1e-06.*correct the initial values")


@pytest.mark.parametrize(("node", "values", "message"), FAST)
def test_inconsistent_initial_velocities_are_projected_and_named(
    mbs, add_pendulum, solve, node, values, message
):
    cable = add_pendulum(mbs)
    mbs.SetNodeParameter(cable["nodes"][node], "initialVelocities", values)
    mbs.Assemble()
    with pytest.warns(UserWarning, match=f"{message}.*limit 1e-06.*kinetic energy from .* J to .* %"):
        report = solve(mbs, 0.02)
    assert report["drift"]["constraints"] < 1e-6


def test_nodes_are_named_by_their_numbers_in_the_system(mbs, add_cable, solve, contents):
    add_cable(mbs, numberOfElements=3)
    cable = add_cable(mbs, positionStart=[0, 1, 0], positionEnd=[1.8, 1, 0])
    assert int(cable["nodes"][3]) == 7
    mbs.SetNodeParameter(cable["nodes"][3], "initialCoordinates", [0, 0, 0.1, 0])
    mbs.Assemble()
    refused(mbs, solve, contents, r"cable 'object1' .* slope of node 7\b")


def test_a_node_whose_reference_was_changed_is_refused(mbs, add_cable, add_pendulum, solve, contents):
    add_cable(mbs, numberOfElements=3)
    cable = add_pendulum(mbs, positionStart=[0, 1, 0], positionEnd=[1.8, 1, 0])
    mbs.SetNodeParameter(cable["nodes"][-1], "referenceCoordinates", [1.8, 0.9, 1, 0])
    mbs.Assemble()
    message = rf"node {int(cable['nodes'][-1])} of cable 'object1' were changed by 0.1 .*initialCoordinates"
    refused(mbs, solve, contents, message)
    refused(mbs, SolveEquilibrium, contents, message)


@pytest.mark.parametrize("name", ["massMatrix", "stiffnessMatrix", "dampingMatrix", "forceVector"])
def test_matrices_of_the_object_of_a_cable_are_refused(mbs, add_pendulum, solve, name):
    cable = add_pendulum(mbs)
    size = 4 * len(cable["nodes"])
    value = np.ones(size) if name == "forceVector" else np.eye(size)
    mbs.SetObjectParameter(cable["elements"][0], name, value)
    mbs.Assemble()
    with pytest.raises(SceneError, match=f"{name} of cable 'object0' was set.*use loads"):
        solve(mbs)


def test_consistent_initial_velocities_of_nodes_are_taken_over(mbs, add_cable, solve):
    cable = add_cable(mbs, gravity=[0, 0, 0])
    for node in cable["nodes"]:
        mbs.SetNodeParameter(node, "initialVelocities", [1, 2, 0, 0])
    mbs.Assemble()
    solve(mbs, 0.1)
    assert mbs.systemData.GetODE2Coordinates()[:2] == pytest.approx([0.1, 0.2])


def test_a_taut_cable_between_two_pins_is_refused(mbs, add_pendulum, solve, contents):
    add_pendulum(mbs, groundConstraintsEnd=[True, True, False, False])
    mbs.Assemble()
    message = r"nodes \d and \d of cable 'object0' is not independent.*let it sag"
    refused(mbs, solve, contents, message, RedundantConstraintError)


@pytest.mark.parametrize("solver", ["VelocityVerlet", "RK44", "ExplicitEuler", "GeneralizedAlpha"])
def test_native_solvers_refuse_the_cable(mbs, add_pendulum, solve, contents, solver):
    add_pendulum(mbs)
    mbs.Assemble()
    before = contents(mbs)
    settings = quiet_settings(0.1, 10)
    settings.timeIntegration.solverType = getattr(exudyn.DynamicSolverType, solver)
    message = "does not enforce inextensibility.*SolveExplicit"
    with silence(), pytest.raises(exudyn.ExudynError, match=f"(?s){message}"):
        mbs.SolveDynamic(settings)
    assert contents(mbs) == before
    assert solve(mbs)["success"]


def test_the_native_static_solver_refuses_the_cable(mbs, add_pendulum, solve):
    add_pendulum(mbs)
    mbs.Assemble()
    settings = quiet_settings(0.1, 1)
    settings.staticSolver.verboseMode = 0
    with silence(), pytest.raises(exudyn.ExudynError, match="does not enforce inextensibility"):
        mbs.SolveStatic(settings)
    assert solve(mbs)["success"]
