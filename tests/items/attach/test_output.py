"""What is seen of a coupled run: solution file, sensors on companions, pictures."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import NodeRigidBody2D, ObjectRigidBody2D, SensorBody
from exudyn.utilities import LoadSolutionFile, SetSolutionState

from exudyn_inext import AttachToBody, CreateCompanionCables
from reference_models.model import quiet_settings, silence
from tests.cables import hermite
from tests.exudyn_binding.items import trajectory

BLUE = np.array([0.0, 0.45, 0.7]) * 255.0  # of the cable


@pytest.fixture
def swung(add_pendulum, add_sensor, solve, tmp_path):
    """A pendulum with a body at its tip after 0.4 s: its system, nodes, sensors, and solution file."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[1.8, -0.1, 0]))
    body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=0.05, inertia=4e-4))
    cable = add_pendulum(mbs)
    AttachToBody(mbs, cable, "end", body, [0, 0.1, 0])
    sensor = SensorBody(bodyNumber=CreateCompanionCables(mbs, cable)[3], localPosition=[0.1, 0, 0])
    sensor.outputVariableType, sensor.storeInternal = exudyn.OutputVariableType.Position, True
    sensors = [mbs.AddSensor(sensor), add_sensor(mbs, node), add_sensor(mbs, cable["nodes"][-1], "Velocity")]
    mbs.Assemble()
    settings = quiet_settings(0.4, 1)
    settings.solution.file.write = True
    settings.solution.file.name = str(tmp_path / "swing.txt")
    settings.solution.file.writePeriod = settings.solution.sensors.writePeriod = 0.05
    assert "joint" in solve(mbs, settings=settings)["path"]
    with silence():
        solution = LoadSolutionFile(settings.solution.file.name)
    return container, mbs, cable["nodes"], sensors, solution


def shown(mbs, solution, row):
    SetSolutionState(mbs, solution, row, sendRedrawSignal=False)


def test_solution_file_leads_back_to_every_state(swung, coordinates):
    _, mbs, nodes, (on_cable, on_body, velocity), solution = swung
    final = mbs.systemData.GetSystemState()
    assert solution["nRows"] == len(trajectory(mbs, on_cable)) == 9
    weights = np.array([p(0.1) for p in hermite(0.36)])
    for row in range(solution["nRows"]):
        shown(mbs, solution, row)
        seen = mbs.GetSensorValues(on_body), mbs.GetSensorValues(velocity), mbs.GetSensorValues(on_cable)
        for sensor, values in zip((on_body, velocity, on_cable), seen, strict=True):
            np.testing.assert_allclose(values, trajectory(mbs, sensor)[row, 1:], atol=1e-7)
        curve = weights @ coordinates(mbs, nodes)[3:5].reshape(4, 2)
        np.testing.assert_allclose(trajectory(mbs, on_cable)[row, 1:3], curve, atol=1e-7)
    for loaded, written in zip(mbs.systemData.GetSystemState()[:3], final[:3], strict=True):
        np.testing.assert_allclose(loaded, written, rtol=1e-6, atol=1e-6)


def test_picture_shows_the_cable_where_it_is(swung, coordinates):
    """Ray-traced without a display; the cable's pixels have the proportions of its curve."""
    container, mbs, nodes, _, solution = swung
    if not hasattr(container.renderer, "RedrawAndGetImage"):
        pytest.skip("this build of Exudyn draws no pictures")
    container.visualizationSettings.view0.window.renderWindowSize = [400, 300]
    for row in (4, 8):
        shown(mbs, solution, row)
        q = coordinates(mbs, nodes)
        points = [p for x in np.linspace(0.0, 0.36, 9) for p in weights_of(x) @ windows(q)]
        width, height = np.ptp(points, axis=0)
        container.renderer.ZoomAll()
        image = np.asarray(container.renderer.RedrawAndGetImage(useRaytracer=True), dtype=float)
        rows, columns = np.nonzero(np.abs(image - BLUE).sum(axis=2) < 60.0)
        assert len(rows) > 50
        assert np.ptp(rows) / np.ptp(columns) == pytest.approx(height / width, rel=0.1)


def weights_of(x):
    return np.array([p(x) for p in hermite(0.36)])


def windows(q):
    """(N, 4, 2) nodal coordinates of each element."""
    return np.concatenate([q[:-1], q[1:]], axis=1)
