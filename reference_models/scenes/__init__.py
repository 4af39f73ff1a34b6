"""All scenes: a module of this folder that defines SCENE is found by itself."""

import importlib
import pkgutil
from collections.abc import Mapping
from types import MappingProxyType

from exudyn_inext.errors import InputError

from .scene import Cable, Clamp, Line, Pin, Reference, Round, Scene


def _find_scenes() -> Mapping[str, Scene]:
    names = sorted(info.name for info in pkgutil.iter_modules(__path__) if info.name != "scene")
    modules = (importlib.import_module(f"{__name__}.{name}") for name in names)
    return MappingProxyType({module.SCENE.name: module.SCENE for module in modules})


SCENES = _find_scenes()


def load_scene(name: str) -> Scene:
    """The scene of that name, e.g. load_scene("planar_pendulum")."""
    if name not in SCENES:
        raise InputError(f"scene '{name}' is unknown; there are: {', '.join(SCENES)}.")
    return SCENES[name]


__all__ = [
    "SCENES",
    "Cable",
    "Clamp",
    "Line",
    "Pin",
    "Reference",
    "Round",
    "Scene",
    "load_scene",
]
