"""Functions of items that depend, within a step, on the time alone: what they read, step functions change."""

from functools import cached_property
from typing import Any

from .functions_of_time import has_sensor_functions, python_function, word_of
from .functions_that_look import Look, asked_item_functions, look_of, may_change_anything


class FunctionsOfSteps:
    """Those of an mbs whose functions and what they read do not change meanwhile.

    Their code shows that they look at nothing of the state, nor store anything, and no other function that is
    called within steps stores anything.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs = mbs

    def __contains__(self, user_function: Any) -> bool:
        """Whether a user function, as Exudyn gives it, is one of them."""
        function = python_function(user_function)
        if word_of(self._mbs, function) is False or look_of(function, self._mbs) > Look.NOTHING:
            return False
        return self._none_changes_anything

    @cached_property
    def _none_changes_anything(self) -> bool:
        if has_sensor_functions(self._mbs):
            return False
        return not any(may_change_anything(one, self._mbs) for one in asked_item_functions(self._mbs))
