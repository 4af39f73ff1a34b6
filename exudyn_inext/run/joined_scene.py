"""What a run needs to know of cables, bodies and joints that move together, whoever evaluates them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..arrays import Array
from ..cable.many_cables import Systems
from ..scene.closed_contacts import ClosedContacts
from ..scene.coupled_system import CoupledSystem
from .compiled_scene import CompiledScene
from .kept_state import Elsewhere
from .parts_in_one import CompiledParts


@dataclass(frozen=True, eq=False)
class OpenContacts:
    """All contacts that are open.   closed: what they do if they close.   name: of them, for messages.

    stiffnesses, dampings: which parameters set them.
    """

    closed: ClosedContacts
    name: str
    stiffnesses: Sequence[str]
    dampings: Sequence[str]


class EvaluatedScene(Protocol):
    """A scene by whom evaluates it: Exudyn, or compiled code.

    forces: (n,) all but gravity on the coordinates at the last evaluation [N, Nm].
    """

    @property
    def forces(self) -> Array: ...

    def report_energy(self, t: float, state: Any, energy_report: Array, scale: float = np.inf) -> None:
        """Of all but the items' work, as `system.report_energy`; the state at t [s] was evaluated last.

        scale: of violated joints [m, -]; infinite: nobody looks at them.
        """

    def kinetic_energy(self, q: Array, v: Array) -> float:
        """With velocities v (n,) at q (n,), the state of the last evaluation [J]."""

    def energies_of_spins(self, duration: float) -> Array:
        """(size,) what a . M a / 2 lacks where bodies turn in space, at the last evaluation [J/s^2].

        duration: of the run [s].
        """

    def leave_out_turns(self, way: Array) -> None:
        """Take whole turns off the angles of bodies in space, in place.   way: (n,)."""

    def violation(self, t: float, q: Array) -> float:
        """Largest violation of a joint [m, -]."""

    def set_multipliers(self, cable: int, t: float, q: Array, v: Array) -> Array:
        """Accelerations of a cable, whose system then holds its multipliers.

        The scene has been evaluated at (t, q, v).
        """


class JoinedScene(EvaluatedScene, Protocol):
    """Parts in one order: cables, bodies, first order states.

    system: all of it.   map: places of the coordinates (`indices`, `reference`, `slices`).   size: how many.
    native_items: forces and joints.   joints: that couple the parts.
    held: coordinates that belong to no part.
    places_of_nodes: first coordinate of each node of cables and bodies, and the dimension of its space.
    cable_systems: of the cables.   groups: of those that share records.
    friction: see `native.friction_check.FrictionCheck`.   tilted_angles: see `native.tilted_angles`.
    remembered: what contacts remember, if there are any.
    initial_state: q and v (size,) at the start.   bodies_of_variable_mass: how many there are.
    parts_in_one: what evaluates bodies and joints, if it is compiled code.
    path: memory of the work of the forces at evaluations, see `build_path`.
    has_steered_joints: whether functions of the user move joints by what they change between steps.
    """

    system: CoupledSystem
    map: Any
    native_items: Any
    held: Any
    cable_systems: Sequence[Any]
    groups: Sequence[Systems]
    joints: Sequence[Any]
    size: int
    has_bodies: bool
    bodies_of_variable_mass: int
    parts_in_one: CompiledParts | None
    path: Array
    tilted_angles: Any

    @property
    def has_steered_joints(self) -> bool: ...

    @property
    def initial_state(self) -> tuple[Array, Array]: ...

    @property
    def places_of_nodes(self) -> dict[int, tuple[int, int]]: ...

    @property
    def friction(self) -> Any: ...

    @property
    def remembered(self) -> Elsewhere | None: ...

    def joined_forces(self) -> Array:
        """(n,) what items and joints did to the coordinates when accelerations were asked for last."""

    def require_finite(self, v: Array) -> None:
        """Raise SceneError unless all velocities v (n,) are finite."""

    def take_hold(self, v: Array, tolerance: float) -> None:
        """Stop the held coordinates at the start; v (n,) in place."""

    def open_contacts(
        self, t: float, q: Array, v: Array, data: Array | None, implicit: np.ndarray
    ) -> OpenContacts | None:
        """Contacts that are open in a state, if there are any.

        data: (D,) of them; None: mbs knows.   implicit: first coordinates of the nodes of cables on which
            damping of contact is implicit; what it does to other parts counts where contact is closed, too.
        """

    def coordinate_name(self, index: int) -> str:
        """Whose coordinate it is, by its place in the system vector."""

    def compiled(self, t: float, q: Array, v: Array, follows_state: bool) -> tuple[CompiledScene | None, str]:
        """The same scene in compiled code, or None and why there is none; (q, v) is a state at t [s].

        follows_state: whether functions of loads may depend on the state.
        """

    def compile_parts(self, t: float, q: Array, v: Array) -> None:
        """Let compiled code evaluate bodies and joints where it can; Exudyn evaluates the forces."""

    def read_masses_again(self) -> None:
        """Bodies may have other masses than when they were read, where Exudyn evaluates them."""

    def leave_compiled_parts(self) -> None:
        """Let Exudyn evaluate bodies and joints, too."""

    def require_agreement(self, form: CompiledScene | None, t: float, q: Array, v: Array) -> None:
        """Raise SceneError if that form is another scene by now; (q, v) is a state at t [s].

        form: None: that of the bodies and joints alone, if there is one.
        """

    def memory(self) -> dict[str, Any]:
        """Drift corrections of joints and bodies, and where joints slide, by names."""

    def forget(self) -> None:
        """Reset drift corrections."""
