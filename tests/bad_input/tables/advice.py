"""Advise and its settings."""

import re
from typing import Any

import exudyn
from exudyn.itemInterface import SensorNode

from exudyn_inext import AdviceSettings, Advise, SceneError

from ..rows import Row, rows
from ..scenes import empty, loose_pendulum, pendulum
from ..values import INF, NAN

FEW = AdviceSettings(numbersOfElements=(2, 3, 4), samplePeriod=1e-3)
KEPT: list[Any] = []


def build(elements: int) -> tuple[Any, int]:
    """The pendulum, and the sensor of its tip."""
    KEPT[:] = [pendulum(numberOfElements=elements)]
    return KEPT[0].mbs, KEPT[0].tip


def loose(elements: int) -> tuple[Any, int]:
    """Not assembled."""
    KEPT[:] = [loose_pendulum(numberOfElements=elements)]
    scene = KEPT[0]
    return scene.mbs, scene.mbs.AddSensor(SensorNode(nodeNumber=scene.node, storeInternal=True))


def without_cable(elements: int) -> tuple[Any, int]:
    """A mass point and its sensor."""
    KEPT[:] = [empty()]
    mbs = KEPT[0].mbs
    point = mbs.CreateMassPoint(mass=1.0, returnDict=True)
    position = exudyn.OutputVariableType.Position
    sensor = mbs.AddSensor(
        SensorNode(nodeNumber=point["nodeNumber"], storeInternal=True, outputVariableType=position)
    )
    mbs.Assemble()
    return mbs, sensor


def of_a_file(elements: int) -> tuple[Any, int]:
    """A sensor that stores nothing."""
    KEPT[:] = [loose_pendulum(numberOfElements=elements)]
    scene = KEPT[0]
    position = exudyn.OutputVariableType.Position
    sensor = scene.mbs.AddSensor(
        SensorNode(nodeNumber=scene.node, writeToFile=False, outputVariableType=position)
    )
    scene.mbs.Assemble()
    return scene.mbs, sensor


def erratic(elements: int) -> tuple[Any, int]:
    """The cable starts elsewhere on each mesh."""
    KEPT[:] = [pendulum(numberOfElements=elements, gravity=[0, 9.81 * (-1) ** elements, 0])]
    return KEPT[0].mbs, KEPT[0].tip


def returning(*what: Any) -> Any:
    """A builder that returns something else beside the mbs, or instead of it."""
    return lambda elements: (build(elements)[0], *what) if what else None


GOOD = {"build": build, "tolerance": 1e-3, "endTime": 0.01, "settings": FEW}
NOT_POSITIVE = (0.0, -1e-3, NAN, INF, "1e-3", True, [1e-3])

ADVISE = [
    *rows(
        Advise,
        GOOD,
        [
            *[
                ({name: value}, rf"{name} = {re.escape(repr(value))}: must be a finite number > 0")
                for name in ("tolerance", "endTime", "budget")
                for value in NOT_POSITIVE
            ],
            ({"tolerance": None}, r"tolerance = None: must be a finite number > 0"),
            ({"endTime": None}, r"endTime = None: must be a finite number > 0"),
            ({"endTime": 1e300}, r"endTime = 1e\+300: must lie between.*units"),
            ({"tolerance": 1e-12}, r"tolerance = 1e-12: the pilots resolve .* at best .*too far.*larger tol"),
            *[
                ({"build": value}, rf"build = {re.escape(repr(value))}: must be a function of a number of")
                for value in (None, 5, "build", ("build",))
            ],
            ({"build": returning()}, r"build\(4\) returned None: must return \(mbs, sensorNumber\)"),
            ({"build": lambda n: build(n)[0]}, r"build\(4\) returned .*: must return \(mbs, sensorNumber\)"),
            ({"build": lambda n: ("mbs", 0)}, r"build\(4\) returned \('mbs', 0\): must return"),
            ({"build": returning(0, 1)}, r"build\(4\) returned .*: must return \(mbs, sensorNumber\)"),
            *[
                (
                    {"build": returning(value)},
                    rf"build\(4\) returned the sensor {re.escape(repr(value))}: must be the number of a "
                    r"sensor of mbs, which has 1, with storeInternal=True",
                )
                for value in (-1, 1, None, "tip", True, 0.0)
            ],
            ({"build": of_a_file}, r"build\(4\) returned the sensor .*with storeInternal=True"),
            (
                {"settings": AdviceSettings(samplePeriod=1e-20)},
                r"samplePeriod = 1e-20 s: .* more than 1e\+06 samples in endTime = 0.01 s; give a larger one",
            ),
            ({"settings": 5}, r"settings = 5: must be AdviceSettings\(\)"),
            ({"settings": {}}, r"settings = \{\}: must be AdviceSettings\(\)"),
            ({"settings": AdviceSettings}, r"settings = <class.*must be AdviceSettings\(\)"),
            (
                {"settings": AdviceSettings(buildConventional=lambda n: None, numbersOfElements=(2, 3, 4))},
                r"buildConventional\(2\) returned None: must return \(mbs, sensorNumber\)",
            ),
        ],
    ),
    *rows(
        Advise,
        GOOD,
        [
            ({"build": loose}, r"mbs is not assembled: call mbs.Assemble\(\)"),
            ({"build": without_cable}, r"no inextensible cable; add one with CreateInextensibleCable"),
            (
                {"build": erratic, "tolerance": 1e-5},
                r"2, 3 and 4 elements do not converge: they differ by .*shorten endTime",
            ),
        ],
        error=SceneError,
    ),
]

SETTINGS = rows(
    AdviceSettings,
    {},
    [
        *[
            ({name: value}, rf"{name} = {re.escape(repr(value))}: must be a finite number > 0")
            for name in ("samplePeriod", "pilotBudget", "axialStiffness")
            for value in NOT_POSITIVE
        ],
        ({"pilotBudget": None}, r"pilotBudget = None: must be a finite number > 0"),
        *[
            (
                {"numbersOfElements": value},
                rf"numbersOfElements = {re.escape(repr(value))}: must be a list of",
            )
            for value in (None, 8, "468", (), [4, 8], range(4, 9))
        ],
        *[
            ({"numbersOfElements": value}, rf"numbersOfElements = {re.escape(repr(value))}: must increase")
            for value in ([4, 4, 8], (8, 6, 4))
        ],
        *[
            ({"numbersOfElements": (value, 6, 8)}, rf"numbersOfElements = {value!r}: must be an integer")
            for value in (0, -4, 4.0, "4", True, 10**6)
        ],
        ({"buildConventional": "native"}, r"buildConventional = 'native': must be a function of a number"),
    ],
    scene=empty,
)

ROWS: list[Row] = [*ADVISE, *SETTINGS]
