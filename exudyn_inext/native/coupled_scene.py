"""Cables, bodies and joints of an mbs as one coupled system, and its compiled form."""

from contextlib import suppress

from ..arrays import Array
from ..constraints.motion import STEP
from ..errors import SceneError
from ..run.compiled_scene import CompiledScene
from ..run.parts_in_one import CompiledParts
from .compiled_form import compiled_form, compiled_parts, require_agreement, settle_general_contact
from .evaluated_scene import SceneOfExudyn
from .known.unknown import UnknownItemError
from .native_items import state_kept


class CoupledScene(SceneOfExudyn):
    """A scene that Exudyn evaluates, of which compiled code takes over what it knows."""

    def compiled(self, t: float, q: Array, v: Array, follows_state: bool) -> tuple[CompiledScene | None, str]:
        """The same scene in compiled code, or None and why there is none; (q, v) is a state at t [s].

        follows_state: whether functions of loads may depend on the state.
        """
        try:
            with state_kept(self.mbs):
                settle_general_contact(self, t, q, v)  # which acts from the start, whoever evaluates it
                return compiled_form(self, t, q, v, follows_state=follows_state), ""
        except UnknownItemError as why:
            return None, str(why)
        finally:
            self.native_items.forget()

    def compile_parts(self, t: float, q: Array, v: Array) -> None:
        """Let compiled code evaluate bodies and joints where it can; Exudyn evaluates the forces."""
        if not (len(self.joints) or len(self.bodies)):
            return
        with suppress(UnknownItemError), state_kept(self.mbs):
            self._take_parts(compiled_parts(self, t, q, v))
        self.native_items.forget()

    def _take_parts(self, parts: CompiledParts | None) -> None:
        self.parts_in_one = self.system.in_one = parts
        self.native_items.subtract_inertia = parts.subtract_inertia if parts else None
        if parts:
            self.system.multipliers = parts.multipliers

    def leave_compiled_parts(self) -> None:
        """Let Exudyn evaluate bodies and joints, too."""
        self._take_parts(None)
        self.read_masses_again()

    def require_agreement(self, form: CompiledScene | None, t: float, q: Array, v: Array) -> None:
        """Raise SceneError if that form is another scene by now; (q, v) is a state at t [s].

        form: None: that of the bodies and joints alone, if there is one.
        """
        parts, has_forces = self.parts_in_one, form is not None
        if form is None:
            if parts is None:
                return
            form = parts.form
        self._take_parts(None)  # Exudyn's side is the other one
        self.read_masses_again()
        try:
            try:
                self._compare(form, t, q, v, has_forces)
            except UnknownItemError:  # or functions of time end at t, by the differences of one side alone
                self._compare(form, t - 5.0 * STEP, q, v, has_forces)
        except UnknownItemError as where:
            raise SceneError(
                f"an item was changed during the run without its notice: {where}. The motion is not that of "
                "the present items: change them by mbs.SetObjectParameter etc., called by name."
            ) from None
        finally:
            self._take_parts(parts)
            self.native_items.forget()

    def _compare(self, form: CompiledScene, t: float, q: Array, v: Array, has_forces: bool) -> None:
        with state_kept(self.mbs):
            require_agreement(self, form, t, q, v, has_forces)
