"""User functions of springs: their forces, or tangents, in the state in which they were asked last."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, placed
from ..errors import SceneError
from ..multibody.connectors import principal_directions
from ..multibody.scene import measure_connectors
from .load_functions import as_array

WAY = 1e-8  # of differences at least, of a stretch or rate up to one
SHARE = 0.05  # of a rate, which may change in a step: tangents are differences over what may change


class AskedSpring(NamedTuple):
    """A spring with a user function.

    place: of its record.   axes: along which it acts.   name: for messages.
    law: (t, stretch, rate, frames) -> forces along these axes [N, Nm]; stretch and rate: (6,),
        frames: (3, 3, 3), see `multibody.connectors`.
    looks: whether anything but that may decide on what it returns.
    """

    place: int
    axes: Sequence[int]
    name: str
    law: Callable[[float, Array, Array, Array], Any]
    looks: bool


class SpringFunctions:
    """Of all springs of a scene.   springs: by their numbers, as they are at present.

    step: in which they are linear about that state [s]; 0: they are constant.
    """

    def __init__(self, springs: Mapping[int, AskedSpring]) -> None:
        self._springs = springs
        self._tangents: dict[int, _Tangent] = {}
        self._are_held, self.step = False, 0.0

    @property
    def name(self) -> str:
        """Of the first one."""
        return next((spring.name for spring in self._springs.values()), "")

    @property
    def look_at_mbs(self) -> bool:
        """Whether one of them may look at more than the motion of its spring."""
        return any(spring.looks for spring in self._springs.values())

    def take(self, system: Any) -> None:
        """The scene to whose records they belong."""
        self._connectors, self._at = system.items.connectors, placed(system)
        self._measure = Prepared(measure_connectors)

    @property
    def memory(self) -> dict[str, Array]:
        """Records of the springs, byte by byte, by names: what their functions said last."""
        places = [spring.place for spring in self._springs.values()]
        return {f"spring {place}": self._connectors[place : place + 1].view(np.uint8) for place in places}

    @contextmanager
    def held(self) -> Iterator[None]:
        """They stay as they are, wherever they are looked at."""
        before, self._are_held = self._are_held, True
        try:
            yield
        finally:
            self._are_held = before

    @contextmanager
    def kept(self) -> Iterator[None]:
        """They are afterwards as they were, wherever they are looked at meanwhile."""
        memory = list(self.memory.values())
        before = [own.copy() for own in memory]
        try:
            yield
        finally:
            for own, values in zip(memory, before, strict=True):
                own[:] = values

    def look(self, t: float, q: Array, v: Array) -> None:
        """Let all springs be what their functions say about the state (q, v) at t [s].

        Raises:
            SceneError: one of them returns something else than numbers.
        """
        if self._are_held or not self._springs:
            return
        self._measure(self._at, q, v)
        for spring in self._springs.values():
            if spring.place not in self._tangents:
                self._tangents[spring.place] = _Tangent(self._connectors, spring.place)
            self._tangents[spring.place].take(spring, t, self.step)


class _Tangent:
    """What the record of a spring says of its law about a state."""

    def __init__(self, connectors: Any, place: int) -> None:
        self._state = connectors["stretch"][place], connectors["rate"][place]
        self._about = connectors["offset"][place], connectors["rate_offset"][place]
        self._slopes = connectors["stiffness"][place], connectors["damping"][place]
        self._force, self._frames = connectors["force"][place], connectors["frame"][place]
        self._directions = connectors["directions"][place]

    def take(self, spring: AskedSpring, t: float, step: float) -> None:
        """About the stretch and rate of the record, at t [s]; constant if the step [s] is zero."""
        force = self._forces(spring, t)
        self._force[spring.axes] = force
        for slopes in self._slopes:
            slopes[:] = 0.0
        if step > 0.0:
            self._set_slopes(spring, t, force, (step, SHARE))

    def _set_slopes(self, spring: AskedSpring, t: float, force: Array, shares: Sequence[float]) -> None:
        """By differences over these shares of the present rates.   force: at present."""
        axes, rates = list(spring.axes), np.abs(self._state[1])
        for present, about, slopes, share in zip(self._state, self._about, self._slopes, shares, strict=True):
            about[:] = present
            for axis in axes:
                present[axis] += max(WAY * max(1.0, abs(about[axis])), share * rates[axis])
                slopes[axes, axis] = (self._forces(spring, t) - force) / (present[axis] - about[axis])
                present[axis] = about[axis]
        if len(axes) > 1 and np.isfinite(self._slopes).all():
            own = np.ix_(axes, axes)
            found = principal_directions(*(slopes[own] for slopes in self._slopes))
            for directions, vectors in zip((self._directions[:6], self._directions[6:]), found, strict=True):
                directions[own] = vectors

    def _forces(self, spring: AskedSpring, t: float) -> Array:
        """Along the axes of a spring; no numbers where steps that are too long lead out of its range."""
        try:
            returned = spring.law(t, *self._state, self._frames)
        except OverflowError:
            return np.full(len(spring.axes), np.nan)
        values = as_array(returned)
        if values is None or values.size != len(spring.axes):
            raise SceneError(
                f"the user function of {spring.name} returned {returned!r} at t = {t:g} s: must return "
                f"{len(spring.axes)} number(s)."
            )
        return values.ravel()
