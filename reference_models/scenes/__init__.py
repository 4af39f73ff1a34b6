"""All scenes: a module of this folder that defines SCENE is found by itself."""

import importlib
import pkgutil
from collections.abc import Mapping
from types import MappingProxyType

from exudyn_inext.errors import InputError

from .load import PointForce, Sine
from .scene import Cable, Reference, Scene
from .section import Round, Section
from .shape import Circle, Line, Parabolas
from .support import Clamp, Hanger, Pin


def _find_scenes() -> Mapping[str, Scene]:
    names = sorted(info.name for info in pkgutil.iter_modules(__path__))
    modules = (importlib.import_module(f"{__name__}.{name}") for name in names)
    scenes = (module.SCENE for module in modules if hasattr(module, "SCENE"))
    return MappingProxyType({scene.name: scene for scene in scenes})


SCENES = _find_scenes()


def load_scene(name: str) -> Scene:
    """The scene of that name, e.g. load_scene("planar_pendulum")."""
    if name not in SCENES:
        raise InputError(f"scene '{name}' is unknown; there are: {', '.join(SCENES)}.")
    return SCENES[name]


__all__ = [
    "SCENES",
    "Cable",
    "Circle",
    "Clamp",
    "Hanger",
    "Line",
    "Parabolas",
    "Pin",
    "PointForce",
    "Reference",
    "Round",
    "Scene",
    "Section",
    "Sine",
    "load_scene",
]
