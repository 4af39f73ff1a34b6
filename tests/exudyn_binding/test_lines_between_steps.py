"""What functions set step by step changes along a line in each step of the loop, whoever evaluates it."""

import exudyn
import numpy as np
import pytest
from exudyn.utilities import (
    CartesianSpringDamper,
    CoordinateConstraint,
    Force,
    InertiaCuboid,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    RevoluteJoint2D,
)

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit

END, LAG = 0.5, 4.0


def wave(t):
    return np.sin(LAG * t + 0.3)


def way(t):
    return 0.05 * (1.0 - np.cos(LAG * t))


class Scene:
    """A planar cable, alone or with a body at its end, that one force or spring pulls, or a joint moves.

    what: pulls it: "alone" or "force", a force; "spring" or "marker", the offset or an end of a spring;
        "offset" or "place", the offset of a constraint or a marker of a joint, which hold its start.
    how: what gives it: "asked", a user function of time, or "set", a function before each step.
    evaluated: whether a spring with a user function leaves all forces to Exudyn.
    """

    def __init__(self, what, how, evaluated=False):
        self.mbs = mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.05)
        moves = what in ("offset", "place")
        ends = {} if moves else {"groundConstraintsStart": [True, True, False, False]}
        cable = CreateInextensibleCable(mbs, [0, 0, 0], [0, -1, 0], 4, section, gravity=[0, -9.81, 0], **ends)
        tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        self.node, self.item = cable["nodes"][-1], None
        ground = mbs.CreateGround()
        if what != "alone":
            body = mbs.CreateRigidBody(
                inertia=InertiaCuboid(500, [0.1, 0.1, 0.1]), referencePosition=[0, -1.1, 0], create2D=True
            )
            held = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[0, 0.1, 0]))
            mbs.AddObject(RevoluteJoint2D(markerNumbers=[tip, held]))
            tip = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
        if evaluated:
            ends = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=k)) for k in (ground, body)]
            nothing = {"springForceUserFunction": lambda mbs, t, item, u, v, k, d, o: [0.0, -u[1], 0.0]}
            mbs.AddObject(CartesianSpringDamper(markerNumbers=ends, **nothing))
        if moves:
            self._move(cable["nodes"][0], ground, how, what)
        elif what in ("spring", "marker"):
            self._pull_by_spring(tip, ground, how, what)
        else:
            self._pull(tip, how)
        mbs.Assemble()

    def _pull(self, tip, how):
        asked = (
            {"loadVectorUserFunction": lambda mbs, t, load: [0.5 * wave(t), 0, 0]} if how == "asked" else {}
        )
        load = self.mbs.AddLoad(Force(markerNumber=tip, loadVector=[0, 0, 0], **asked))
        self.get = lambda: self.mbs.GetLoadParameter(load, "loadVector")[0] / 0.5
        if how == "set":
            self._before_steps(lambda t: self.mbs.SetLoadParameter(load, "loadVector", [0.5 * wave(t), 0, 0]))

    def _pull_by_spring(self, tip, ground, how, what):
        def law(mbs, t, item, u, v, k, d, o):
            return [20.0 * (u[0] - 0.1 * wave(t)) + v[0], 0.0, 0.0]

        asked = {"springForceUserFunction": law} if how == "asked" else {}
        ends = [self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground)), tip]
        values = {"stiffness": [20, 0, 0], "damping": [1, 0, 0]}
        spring = self.mbs.AddObject(CartesianSpringDamper(markerNumbers=ends, **values, **asked))
        if how == "set" and what == "spring":
            self._before_steps(lambda t: self.mbs.SetObjectParameter(spring, "offset", [0.1 * wave(t), 0, 0]))
        elif how == "set":
            place = ends[0], "localPosition"
            self._before_steps(lambda t: self.mbs.SetMarkerParameter(*place, [0.1 * wave(t), 0, 0]))

    def _move(self, node, ground, how, what):
        mbs = self.mbs
        start = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        carriage = mbs.CreateMassPoint(mass=1.0, create2D=True)
        held = mbs.AddMarker(MarkerBodyPosition(bodyNumber=carriage))
        mbs.AddObject(RevoluteJoint2D(markerNumbers=[held, start]))
        if what == "place" and how == "set":
            anchor = mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground))
            mbs.AddObject(RevoluteJoint2D(markerNumbers=[anchor, held]))
            place = anchor, "localPosition"
            self._before_steps(lambda t: mbs.SetMarkerParameter(*place, [way(t), 0, 0]))
            return
        node = mbs.GetObject(carriage)["nodeNumber"]
        asked = {"offsetUserFunction": lambda mbs, t, item, offset: way(t)} if how == "asked" else {}
        fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        x, y = (mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k)) for k in (0, 1))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, y]))
        joint = mbs.AddObject(CoordinateConstraint(markerNumbers=[fixed, x], **asked))
        if how == "set":
            self._before_steps(lambda t: mbs.SetObjectParameter(joint, "offset", float(way(t))))

    def _before_steps(self, put):
        def before(mbs, t):
            put(t)
            return True

        self.mbs.SetPreStepUserFunction(before)

    def solve(self, steps, h, **explicit):
        settings = exudyn.SimulationSettings()
        settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = END, steps
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        self.report = SolveExplicit(self.mbs, settings, ExplicitSettings(stepSize=h, **explicit))
        return self.mbs.GetNodeOutput(self.node, exudyn.OutputVariableType.Position)


def errors(what, evaluated, steps_and_substeps, **explicit):
    """Of the free end [m], by the numbers of steps of the loop and of those in each of them."""
    h = END / max(steps * substeps for steps, substeps in steps_and_substeps)
    exact = Scene(what, "asked", evaluated).solve(1, h, **explicit)
    return [
        np.linalg.norm(
            Scene(what, "set", evaluated).solve(steps, END / (steps * substeps), **explicit) - exact
        )
        for steps, substeps in steps_and_substeps
    ]


@pytest.mark.parametrize(
    "what, evaluated",
    [("alone", False), ("force", False), ("force", True), ("spring", False), ("marker", False)],
)
def test_values_that_are_set_act_with_second_order_in_the_step_of_the_loop(what, evaluated):
    coarse, fine = errors(what, evaluated, [(25, 8), (50, 4)])
    assert fine < 0.35 * coarse
    assert coarse < 0.1 * END / 25 / 2 * LAG  # of what half a step of the loop is ahead


@pytest.mark.parametrize("evaluated", [False, True])
@pytest.mark.parametrize("what", ["offset", "place"])
def test_joints_that_are_set_move_with_second_order_in_the_step_of_the_loop(what, evaluated):
    coarse, fine = errors(what, evaluated, [(25, 8), (50, 4)])
    assert fine < 0.35 * coarse
    assert coarse < 0.1 * END / 25 / 2 * LAG


@pytest.mark.parametrize("what", ["offset", "place"])
def test_so_they_do_where_exudyn_evaluates_them(what, by_exudyn):
    coarse, fine = errors(what, False, [(25, 8), (50, 4)])
    assert fine < 0.35 * coarse


@pytest.mark.parametrize("what", ["alone", "force"])
@pytest.mark.parametrize("integrator", ["RK4", "Zhai"])
def test_so_they_do_with_other_integrators(what, integrator):
    coarse, fine = errors(what, False, [(25, 8), (50, 4)], integrator=integrator)
    assert fine < 0.35 * coarse


def test_evaluated_items_have_their_values_at_the_end():
    scene = Scene("force", "set", evaluated=True)
    scene.solve(20, END / 160)
    assert scene.get() == wave(END)


def test_the_energy_counts_the_work_of_a_force_on_its_way():
    scene = Scene("alone", "set")
    scene.solve(25, END / 200)
    assert scene.report["drift"]["energyGain"] < 1e-3
