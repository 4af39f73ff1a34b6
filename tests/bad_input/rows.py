"""A row of the table of bad input: a call, and the error that has to come of it."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from exudyn_inext import CreateInextensibleCable, InputError
from tests.scene_contents import contents

from .scenes import cable_arguments, pendulum, run


def assemble_and_run(scene: Any) -> None:
    """The system is as good as before: it runs, if need be with a first cable."""
    if not hasattr(scene, "cable"):
        CreateInextensibleCable(scene.mbs, **cable_arguments())
    scene.mbs.Assemble()
    assert run(scene.mbs)["success"]


def nothing_more(scene: Any) -> None:
    """Where the scene itself is at fault."""


def all_but_the_time(mbs: Any) -> Any:
    """Where Exudyn counts on before it asks."""
    return contents(mbs)[:-1]


@dataclass(frozen=True)
class Row:
    """Bad input.

    call: public function, or what calls it.   arguments: for it; `Of` stands for what the scene provides.
    message: regular expression: value, limit or culprit, remedy.   error: its type.
    scene: builds what is called upon.   of: public name that is at fault, if it is not `call`.
    good: what works afterwards.   kept: what of the mbs must not change.
    """

    call: Callable[..., Any]
    arguments: Mapping[str, Any]
    message: str
    error: type[Exception] = InputError
    scene: Callable[[], Any] = pendulum
    of: Any = None
    good: Callable[[Any], None] = assemble_and_run
    kept: Callable[[Any], Any] = contents

    @property
    def who(self) -> str:
        """The public name that the row is about."""
        culprit: str = (self.of or self.call).__qualname__
        return culprit.split(".")[0]

    def __str__(self) -> str:
        return f"{self.who}: {self.message}"


def rows(
    call: Callable[..., Any],
    base: Mapping[str, Any],
    cases: Iterable[tuple[Mapping[str, Any], str]],
    **options: Any,
) -> list[Row]:
    """One row for each case: arguments that replace those of `base`, and the message."""
    return [Row(call, {**base, **changes}, message, **options) for changes, message in cases]
