"""Cost and memory of long cables.

Question
    Does an element cost the same in a cable of 20 as in one of 10 000, and how long may a cable be?

What would refute it
    Cost per element and step that varies by more than 25 % over N = 20 to 10 000; 1 GB for 100 000 elements;
    with scaled mass at h = 2e-3 s, errors of the planar pendulum above 1e-3 m or a cost out of proportion
    to N for N = 10, 100, 1000; 5000 elements slower than real time.

Protocol
    Cost: compiled steps (ExplicitStepper.Step) of the pendulums and of the free ring, pulled by two forces
    of 1 N, mass scaling 0.3, h = 1e-3 s, so that all meshes move alike; CPU time, round robin over all N,
    medians. A stepper begins anew after 3 s of motion. Zhai does the same work in all steps; RATTLE
    corrects positions as often as its tolerance asks for. The memory of a step is what it goes through: the
    records of nodes and elements, and the integrator's arrays.
    Memory: largest resident memory of a process that builds the pendulum as an mbs and steps it.
    Accuracy: 5 s of the planar pendulum with the tip at 100 Hz against the independent reference
    (good to 5e-5 m), start and steps timed, building not.

What is left out
    Building the model: some 30 us an element.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.model import SENSOR_PERIOD
from reference_models.scenes import load_scene
from reference_models.trajectory import Case, Run, Trajectory
from studies.harness import Row
from studies.harness.inner import element_type, node_type
from studies.harness.memory import long_cable
from studies.harness.process import ask
from studies.harness.ratios import INEXTENSIBLE
from studies.harness.reference import from_data
from studies.harness.timing import Prepare, Task, row_of

PLANAR = load_scene("planar_pendulum")
RING = replace(load_scene("vibrating_ring"), loads=())
CHAINS = {"2D": PLANAR, "3D": load_scene("spatial_pendulum"), "2D, closed": RING}
INTEGRATORS = {"Zhai": 9, "RATTLE": 7}  # arrays of the integrator, and the constant force
RING_FORCE = 1.0  # [N]
PORTION, RESTART = 1000, 3.0  # steps in one call; [s] of motion
THETA = 0.3
MICRO = 1e6


def steps(case: Row) -> dict[int, Task]:
    """Elements -> steps of a chain."""
    scene, elements = CHAINS[case["chain"]], case["elements"]
    model = build(scene, elements)
    explicit = ExplicitSettings(case["integrator"], stepSize=1e-3, massScaling=THETA)
    stepper = ExplicitStepper(model.mbs, explicit)
    if scene is RING:
        stepper.SetNodeForce(model.nodes[0], [RING_FORCE, 0.0, 0.0])
        stepper.SetNodeForce(model.nodes[elements // 2], [-RING_FORCE, 0.0, 0.0])
    stepper.Start()

    def task(times: int) -> None:
        while times:
            portion = min(times, PORTION)
            if stepper.time + portion * stepper.stepSize > RESTART:
                stepper.Start()
            stepper.Step(portion)
            times -= portion

    return {elements: task}


def cost(case: Row, found: Any) -> Row:
    """CPU time of an element's step; its memory: records of a node and an element, and arrays."""
    elements, integrator = case["elements"], case["integrator"]
    dim = 2 if CHAINS[case["chain"]].is_planar else 3
    records = node_type(dim).itemsize + element_type(dim, product=False).itemsize
    return {
        "label": f"{case['chain']}, {integrator}",
        "elements": elements,
        "microseconds": MICRO * found[elements].median / elements,
        "megabytes": elements * (records + INTEGRATORS[integrator] * 2 * dim * 8) / 1e6,
    }


def memory(case: Row) -> Row:
    """Of a process that builds the pendulum and steps it."""
    found = ask(long_cable, CHAINS[case["chain"]].name, case["elements"], case["steps"])
    return {"label": f"{case['chain']}, RATTLE", **found}


def motion(case: Row) -> dict[Any, Prepare]:
    """The planar pendulum, with the tip at 100 Hz."""
    one = _case(case)
    return {one.label: one.prepare}


def _case(case: Row) -> Case:
    """Start and steps of a stepper; what is timed."""
    elements, h, samples = case["elements"], 2e-3, round(case["motion"] / SENSOR_PERIOD)
    settings = ExplicitSettings(case["integrator"], stepSize=h, massScaling=THETA)

    def prepare() -> Run:
        stepper = ExplicitStepper(build(PLANAR, elements).mbs, settings, interval=SENSOR_PERIOD)
        tip, positions = stepper.State()[0][-1, 0], np.zeros((samples + 1, 3))

        def run() -> Trajectory:
            stepper.Start()
            positions[0, :2] = tip
            for k in range(samples):
                stepper.Step()
                positions[k + 1, :2] = tip
            return Trajectory(SENSOR_PERIOD * np.arange(samples + 1), positions)

        return run

    steps, label = round(case["motion"] / h), f"{case['integrator']}, N = {elements}"
    details = {"massScaling": THETA}
    return Case(label, INEXTENSIBLE, case["integrator"], elements, h, steps, prepare, details)


def accuracy(case: Row, found: Any) -> Row:
    """Errors, cost of an element's step, and seconds of motion a second of CPU time."""
    one = _case(case)
    row = row_of(one, found[one.label], from_data(PLANAR).trajectory)
    seconds, work = row["cpuSeconds"], row["steps"] * row["elements"]
    rates = {"microseconds": MICRO * seconds / work, "realTime": case["motion"] / seconds}
    return {"motion": case["motion"], **row, **rates}
