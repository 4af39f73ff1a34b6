"""Advice for a scene: pilots of its inextensible and its native cables."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from exudyn_inext import AdviceSettings, Advise

from .conventional.model import build as build_native
from .inextensible import build
from .model import SENSOR_PERIOD, Model
from .scenes import Scene


def advise_scene(
    scene: Scene, tolerance: float, budget: float | None = None, settings: AdviceSettings | None = None
) -> dict[str, Any]:
    """`Advise` for a scene's main point, its axial stiffness and native cables known.

    Args:
        scene: what is to be run.   tolerance: of the main point [m].   budget: CPU time of a run [s].
        settings: of the pilots; sample period, axial stiffness and native cables are set here.
    """
    known = replace(
        settings or AdviceSettings(),
        samplePeriod=SENSOR_PERIOD,
        axialStiffness=scene.cable.section.axial_stiffness,
        buildConventional=builder(scene, partial(build_native, quadrature="lobatto")),
    )
    return Advise(builder(scene, build), tolerance, scene.end_time, budget, known)


def builder(scene: Scene, build_model: Callable[[Scene, int], Model]) -> Callable[[int], tuple[Any, int]]:
    """Number of elements -> mbs, and the sensor of the main point; for `Advise`."""
    models: list[Model] = []  # an mbs lives as long as its container

    def built(elements: int) -> tuple[Any, int]:
        models[:] = [*models[-1:], build_model(scene, elements)]
        model = models[-1]
        return model.mbs, model.sensors[scene.main_point]

    return built
