"""At default settings, SolveExplicit, ExplicitStepper and SolveEnsemble take the same steps."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import LoadMassProportional, MarkerBodyMass, SensorNode

from exudyn_inext import (
    AddPointMass,
    CableDrag,
    CreateCompanionCables,
    CreateInextensibleCable,
    ExplicitSettings,
    ExplicitStepper,
    InextensibleCable,
    SetCableDrag,
    SolveEnsemble,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import COARSE, load_node

END, PERIOD = 0.5, 0.01
PINNED, CLAMPED = [True, True, False, False], [True] * 4


def cable(section=(0.1, 1.0), elements=8, add=None, **changes):
    """An assembled cable of 1 m with a sensor at its tip; section: rho_A, EI, and D if it is damped."""
    mbs = exudyn.SystemContainer().AddSystem()
    names = ("massPerLength", "bendingStiffness", "bendingDamping")
    arguments = {
        "positionStart": [0, 0, 0],
        "positionEnd": [1, 0, 0],
        "numberOfElements": elements,
        "beamTemplate": InextensibleCable(**dict(zip(names, section, strict=False))),
        "gravity": [0, -9.81, 0],
        "groundConstraintsStart": PINNED,
    }
    items = CreateInextensibleCable(mbs, **(arguments | changes))
    if add:
        add(mbs, items)
    kind = exudyn.OutputVariableType.Position
    mbs.AddSensor(SensorNode(nodeNumber=items["nodes"][-1], storeInternal=True, outputVariableType=kind))
    mbs.Assemble()
    return mbs


def stiff_pendulum():
    """Exudyn's flexible pendulum: plain explicit steps would have to be below 1.4e-6 s."""
    return cable(section=(10.0, 10937.5), elements=25)


def spatial(**changes):
    return cable(dimension=3, groundConstraintsStart=[True] * 3 + [False] * 3, **changes)


def weigh(mbs, items):
    for companion in CreateCompanionCables(mbs, items):
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=companion))
        mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[3.0, 0, 0]))


def push(mbs, items):
    def force(mbs, t, load):
        return [0.0, 2.0 * np.sin(10.0 * t), 0.0]

    load_node(mbs, items["nodes"][-1], [0, 0, 0], loadVectorUserFunction=force)


def add_a_second_one(mbs, items):
    CreateInextensibleCable(mbs, [0, 1, 0], [1, 1, 0], 4, InextensibleCable(0.1, 5.0), gravity=[0, -9.81, 0])


SCENES = {
    "undamped": cable,
    "stiff": stiff_pendulum,
    "soft": lambda: cable(section=(0.1, 1e-4)),
    "bending-damped": lambda: cable(section=(0.1, 1.0, 0.1)),
    "dragged": lambda: cable(
        add=lambda mbs, items: SetCableDrag(mbs, items, CableDrag(1.2, 0.0, 0.05, 1000.0))
    ),
    "point mass": lambda: cable(add=lambda mbs, items: AddPointMass(mbs, items, 1.0, 2.0)),
    "mass-loaded": lambda: cable(add=weigh),
    "pushed": lambda: cable(add=push),
    "too fast for its first step": lambda: cable(
        section=(0.1, 100.0), elements=4, groundConstraintsStart=CLAMPED
    ),
    "two cables": lambda: cable(add=add_a_second_one),
    "spatial": spatial,
    "spatial, bending-damped": lambda: spatial(section=(0.1, 1.0, 0.1)),
}
DERIVATIVES = ("coordinates", "velocities", "accelerations")


def settings():
    return quiet_settings(END, 1, PERIOD)


def state(mbs):
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def stepper_of(mbs, interval=PERIOD, **explicit):
    """A stepper that has begun."""
    stepper = ExplicitStepper(mbs, ExplicitSettings(**explicit), interval=interval, duration=END)
    stepper.Start()
    return stepper


@pytest.mark.parametrize("name", SCENES)
@COARSE
def test_the_same_scene_takes_the_same_steps_by_all_three_ways(name):
    run, by_stepper = SCENES[name](), SCENES[name]()
    with silence():
        report = SolveExplicit(run, settings())
    stepper = stepper_of(by_stepper)
    stepper.Step(round(END / PERIOD))
    stepper.WriteToSystem()
    result = SolveEnsemble([SCENES[name]()], settings(), derivatives=2)
    np.testing.assert_array_equal(state(by_stepper), state(run))
    np.testing.assert_array_equal([result[kind][0, -1] for kind in DERIVATIVES], state(run))
    assert stepper.massScaling == result["massScaling"][0] == report["massScaling"]
    assert stepper.bounds == result["bounds"][0] == report["bounds"]
    assert stepper.decidedBy == result["decidedBy"][0] == report["decidedBy"]
    assert result["stepSize"][0] == report["stepSize"] and result["steps"][0] == report["steps"]
    is_halved = stepper.stepSize > 1.5 * report["stepSize"]
    assert is_halved == (name == "too fast for its first step")


@pytest.mark.parametrize("name", ["pushed", "bending-damped", "soft"])
@COARSE
def test_portions_of_intervals_give_the_same_bits(name):
    whole, parts = SCENES[name](), SCENES[name]()
    with silence():
        SolveExplicit(whole, settings())
    stepper = stepper_of(parts)
    for n in (1, 1, 7, 41):
        stepper.Step(n)
    stepper.WriteToSystem()
    assert stepper.time == pytest.approx(END, rel=1e-12)
    np.testing.assert_array_equal(state(parts), state(whole))


@COARSE
def test_members_that_want_different_steps_take_their_own():
    sections = {"light": (0.1, 1.0), "stiff": (10.0, 1000.0), "soft": (0.1, 1e-4), "heavy": (0.1, 1.0)}
    weights = {"heavy": [0.0, -981.0, 0.0]}

    def build(name):
        return cable(sections[name], gravity=weights.get(name, [0, -9.81, 0]))

    result = SolveEnsemble(build, settings(), parameters=list(sections), derivatives=2, threads=2)
    assert len(set(result["stepSize"])) > 1 and set(result["massScaling"]) == {0.0, 0.3}
    for member, name in enumerate(sections):
        alone = build(name)
        with silence():
            report = SolveExplicit(alone, settings())
        np.testing.assert_array_equal([result[kind][member, -1] for kind in DERIVATIVES], state(alone))
        for what in ("stepSize", "steps", "massScaling", "decidedBy", "bounds"):
            assert result[what][member] == report[what], (name, what)


def test_outputs_at_every_step_are_those_of_the_shortest_one():
    every_step = quiet_settings(END, 1, 0.0)
    result = SolveEnsemble([cable(), cable(gravity=[0, -981.0, 0])], every_step)
    assert len(result["times"]) == result["steps"][1] + 1 == result["steps"][0] + 1
    assert result["stepSize"][0] == result["stepSize"][1] <= result["bounds"][1].accuracy


@pytest.mark.parametrize("interval", [PERIOD, 1e-3, 7e-4])
@pytest.mark.parametrize("given", [{}, {"stepSize": 6e-4, "massScaling": 0.3}])
def test_the_step_of_a_stepper_divides_its_interval(interval, given):
    stepper = stepper_of(cable(), interval, **given)
    wanted = given.get("stepSize", stepper.bounds.accuracy)
    number = interval / stepper.stepSize
    assert number == pytest.approx(round(number), rel=1e-12)
    assert stepper.stepSize <= wanted and (round(number) == 1 or interval / (round(number) - 1) > wanted)
    stepper.Step(3)
    assert stepper.time == pytest.approx(3 * interval, rel=1e-12) and stepper.interval == pytest.approx(
        interval
    )


def test_without_an_interval_a_step_is_the_longest_one():
    stepper = stepper_of(cable(), interval=None)
    assert stepper.stepSize == stepper.interval == stepper.bounds.accuracy


def test_a_stiff_pendulum_takes_few_steps():
    stepper = stepper_of(stiff_pendulum())
    assert stepper.massScaling == 0.3 and END / stepper.stepSize < 2000
    result = SolveEnsemble([stiff_pendulum()], settings())
    assert result["massScaling"][0] == 0.3 and result["steps"][0] < 2000


def test_steps_that_are_too_long_are_halved_between_calls_as_between_user_functions():
    """What has been handed out stays; a new start forgets what has been learned."""
    run, parts = (SCENES["too fast for its first step"]() for _ in range(2))
    run.SetPreStepUserFunction(lambda mbs, t: True)
    with silence():
        report = SolveExplicit(run, settings())
    stepper = stepper_of(parts)
    assert report["stepSize"] < 0.6 * stepper.stepSize
    for _ in range(2):
        stepper.Start()
        for _ in range(round(END / PERIOD)):
            stepper.Step()
        stepper.WriteToSystem()
        np.testing.assert_array_equal(state(parts), state(run))


def test_damping_that_shortens_the_step_is_said_before_the_run():
    explicit = ExplicitSettings("RK4")
    damped = SCENES["bending-damped"]
    with pytest.warns(UserWarning, match=r"damping .* bounds the step"):
        ExplicitStepper(damped(), explicit)
    with pytest.warns(UserWarning, match=r"damping .* of member 1 bounds the step"):
        SolveEnsemble([cable(section=(0.1, 1.0, 0.01)), damped()], quiet_settings(1e-4, 1, PERIOD), explicit)
