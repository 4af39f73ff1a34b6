"""Outputs of replaced elements and their nodes that user functions read, and that are not as natively."""

import warnings
from collections.abc import Iterator, Sequence
from typing import Any

from ..items.arguments import described
from ..items.functions_of_time import package_of, python_function, step_functions
from ..items.functions_that_look import names_read_by
from ..scene.model import Scene
from .sensors import WITHOUT_COMPANIONS

_OF_ACCELERATION = {
    "Acceleration",
    "AccelerationLocal",
    "AngularAcceleration",
    "AngularAccelerationLocal",
    "Coordinates_tt",
    "GetODE2Coordinates_tt",
}
_INSTEAD = {kind.name: sensor for kind, sensor in WITHOUT_COMPANIONS.items()}


def warn_of_unseen_outputs(
    mbs: Any, scene: Scene, sensors: Sequence[dict[str, Any]], at_rest: bool = False
) -> None:
    """Warn of user functions that read section forces, or accelerations within steps, of replaced elements.

    As far as their code shows.

    Args:
        mbs: the system.   scene: of it.   sensors: data of all of its sensors.
        at_rest: whether no steps are taken: accelerations are zero then.
    """
    if not any(one.item.replaced for one in scene.cables):
        return
    for name, function in _between_steps(mbs, sensors):
        _warn_of_section_forces(name, names_read_by(function, mbs))
    for name, function in _within_steps(mbs):
        names = names_read_by(function, mbs)
        _warn_of_section_forces(name, names)
        if not at_rest and (read := names & _OF_ACCELERATION):
            warnings.warn(
                f"the user function of {name} reads {min(read)}, which explicit steps know of the step "
                "before only: what follows it comes a step late, and runs away if it exceeds what the mass "
                "there takes. Take a mass (AddPointMass) in place of a force that follows the acceleration.",
                stacklevel=4,
            )


def _warn_of_section_forces(name: str, names: set[str]) -> None:
    for output in sorted(names & _INSTEAD.keys()) if "GetObjectOutputBody" in names else ():
        warnings.warn(
            f"the user function of {name} reads {output} by GetObjectOutputBody: it is zero of elements that "
            f"cables replaced. Use {_INSTEAD[output]}: let a step function read that sensor "
            "(mbs.GetSensorValues), and set by it what follows it.",
            stacklevel=4,
        )


def _between_steps(mbs: Any, sensors: Sequence[dict[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Functions that are called after steps, and whose they are."""
    for function in step_functions(mbs):
        yield "mbs (before or after steps)", function
    for number, data in enumerate(sensors):
        for function in _of_user(data):
            yield f"sensor {number} '{data['name']}'", function


def _within_steps(mbs: Any) -> Iterator[tuple[str, Any]]:
    """Functions of loads and objects, and whose they are."""
    for number in range(mbs.systemData.NumberOfLoads()):
        data = mbs.GetLoad(number)
        for function in _of_user(data):
            yield f"load {number} '{data['name']}' ({data['loadType']})", function
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        for function in _of_user(data):
            yield described(data, number), function


def _of_user(data: dict[str, Any]) -> list[Any]:
    """Functions of an item, but not those of this package.   data: of the item."""
    given = [one for key, one in data.items() if "UserFunction" in key and key[0] != "V"]
    functions = [python_function(one) for one in given if isinstance(one, dict)]
    return [one for one in functions if package_of(one) != __name__.split(".")[0]]
