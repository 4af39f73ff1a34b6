"""Nets of cables: what they cost grows with their size, not with its square."""

import tracemalloc

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import MarkerNodePosition, SphericalJoint

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit
from reference_models.model import quiet_settings

ELEMENTS, STEPS, STEP = 4, 20, 1e-3


def add_net(mbs, side, enforcement="projection"):
    """Cables between side x side knots out of a plane, joined there; returns their nodes at the knots."""
    section = InextensibleCable(massPerLength=0.05, bendingStiffness=1e-3)
    knots = {
        (i, j): [0.9 * i, 0.9 * j, 0.2 * np.sin(2.1 * i + 0.7 * j)] for i in range(side) for j in range(side)
    }
    at = {knot: [] for knot in knots}
    for i, j in knots:
        for other in ((i + 1, j), (i, j + 1)):
            if other in knots:
                cable = CreateInextensibleCable(
                    mbs,
                    knots[i, j],
                    knots[other],
                    ELEMENTS,
                    section,
                    gravity=[0, 0, -9.81],
                    dimension=3,
                    enforcement=enforcement,
                )
                at[i, j].append(cable["nodes"][0])
                at[other].append(cable["nodes"][-1])
    for nodes in at.values():
        markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
        for marker in markers[1:]:
            mbs.AddObject(SphericalJoint(markerNumbers=[markers[0], marker]))
    mbs.Assemble()
    return at


def wind(mbs, at):
    """Velocities that bend the net, of its knots."""
    system = np.zeros(mbs.systemData.ODE2Size())
    for (i, j), nodes in at.items():
        for node in nodes:
            places = mbs.systemData.GetNodeLTGODE2(node)[:3]
            system[places] = [0.0, 0.0, np.cos(1.7 * i - 0.9 * j)]
    mbs.systemData.SetODE2Coordinates_t(system.tolist(), exudyn.ConfigurationType.Initial)


def test_a_net_moves_as_under_the_implicit_solver(new_mbs):
    ends = []
    for enforcement in ("projection", "algebraic"):
        mbs = new_mbs()
        at = add_net(mbs, 3, enforcement)
        settings = quiet_settings(STEPS * STEP, STEPS, STEP)
        if enforcement == "projection":
            SolveExplicit(mbs, settings, ExplicitSettings(stepSize=STEP / 4))
        else:
            settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
            settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
            mbs.SolveDynamic(settings)
        output = exudyn.OutputVariableType.Displacement
        ends.append(np.array([mbs.GetNodeOutput(nodes[0], output) for nodes in at.values()]))
    fallen = np.abs(ends[1]).max()
    assert fallen > 1e-3
    assert np.abs(ends[0] - ends[1]).max() < 0.01 * fallen


def test_nothing_dense_in_the_size_of_the_net(new_mbs):
    mbs = new_mbs()
    add_net(mbs, 7)
    settings = quiet_settings(2 * STEP, 1, STEP)
    tracemalloc.start()
    try:
        SolveExplicit(mbs, settings, ExplicitSettings(stepSize=STEP))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    dense = 8 * mbs.systemData.ODE2Size() ** 2
    assert peak < 0.5 * dense


def test_knots_stay_together(new_mbs):
    mbs = new_mbs()
    at = add_net(mbs, 4)
    wind(mbs, at)
    with pytest.warns(UserWarning, match="initial velocities"):
        SolveExplicit(mbs, quiet_settings(0.2, 1, 0.2))
    output = exudyn.OutputVariableType.Position
    gaps = [
        np.abs(mbs.GetNodeOutput(node, output) - mbs.GetNodeOutput(nodes[0], output)).max()
        for nodes in at.values()
        for node in nodes
    ]
    assert max(gaps) < 1e-9
