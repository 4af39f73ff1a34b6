"""The members of an ensemble: systems with equally many coordinates, read one by one, each with its step."""

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..errors import InextensibleError, InputError
from ..run.coupled_run import Run
from ..run.settings import ExplicitSettings
from ..run.step_choice import StepChoice, choose_step
from .scene_runs import compiled_runs

REMEDY = "members must not differ in it; put the others into an ensemble of their own."


@dataclass(frozen=True, eq=False)
class Member:
    """One system of an ensemble.

    runs: one for each cable, or one for cables among bodies.   reference: (n,) coordinates of the mbs.
    choice: of its step.
    """

    runs: Sequence[Run]
    reference: Array
    choice: StepChoice


def all_systems(systems: Any, parameters: Iterable[Any] | None) -> list[Callable[[], Any]]:
    """One function for each member that gives its mbs; arguments: see `SolveEnsemble`.

    Raises:
        InputError: no member at all, `parameters` without a builder, or a builder without `parameters`.
    """
    if callable(systems) != (parameters is not None):
        raise InputError(
            "SolveEnsemble takes a sequence of assembled systems, or a function that builds one and the "
            "list of its parameters: "
            + ("parameters are missing." if callable(systems) else "systems is no function.")
        )
    function, values = (lambda mbs: mbs, systems) if parameters is None else (systems, parameters)
    if not isinstance(values, Iterable) or isinstance(values, str | bytes | dict):
        what = "systems" if parameters is None else "parameters"
        raise InputError(f"{what} = {values!r}: must be a sequence, one entry a member.")
    builders: list[Callable[[], Any]] = [partial(function, value) for value in values]
    if not builders:
        raise InputError("the ensemble is empty: give at least one system.")
    return builders


def read_members(
    builders: Iterable[Callable[[], Any]],
    time: float,
    duration: float,
    h: float,
    explicit: ExplicitSettings,
    longest: float,
) -> Iterator[Member]:
    """All members, one after the other, ready to start.

    Args:
        builders: see `all_systems`.   time: of the start [s].   duration: of the run [s].
        h: given step that scales the mass [s]; 0 without it.   explicit: settings.
        longest: step that outputs allow [s].

    Raises:
        InputError: members of different numbers of coordinates.
        SceneError: a member that is not assembled, or contains what is not supported.
        StepSizeError: the given step is above the stability limit of a member.
    """
    first: Member | None = None
    for number, mbs_of in enumerate(builders):
        with _naming(number):
            mbs = mbs_of()
            with _naming_warnings(number):
                member = _member(mbs, time, duration, h, explicit, longest)
            first = first or member
            size, wanted = len(member.reference), len(first.reference)
            if size != wanted:
                raise InputError(f"number of coordinates = {size}, that of member 0 is {wanted}: {REMEDY}")
        yield member


def _member(
    mbs: Any, time: float, duration: float, h: float, explicit: ExplicitSettings, longest: float
) -> Member:
    runs, is_told = _runs(mbs, time, h, explicit), not explicit.allowUnstableStep
    choice = choose_step(runs, time, duration, explicit, h, is_told=is_told, longest=longest)
    reference = mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Reference)
    return Member(runs, np.asarray(reference), choice)


@contextmanager
def _naming(number: int) -> Iterator[None]:
    """Every error of the package says which member it is about."""
    try:
        yield
    except InextensibleError as error:
        error.args = (f"member {number} of the ensemble: {error}", *error.args[1:])
        raise


@contextmanager
def _naming_warnings(number: int) -> Iterator[None]:
    """So does every warning."""
    found: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            yield
    finally:
        for one in found:
            warnings.warn(f"member {number} of the ensemble: {one.message}", one.category, stacklevel=2)


def _runs(mbs: Any, time: float, h: float, explicit: ExplicitSettings) -> Sequence[Run]:
    if not hasattr(mbs, "systemIsConsistent"):
        raise InputError(f"{mbs!r} is no system of Exudyn (mbs): a builder must return it.")
    return compiled_runs(mbs, time, h, explicit, "SolveEnsemble", "within an ensemble")
