"""Pages of source code share their navigation: to build it anew takes longer than all else on such a page."""

from collections.abc import Callable
from typing import Any

BEFORE_THE_THEME = 400  # priority of handlers; the theme asks for the navigation at 500


class SharedNavigation:
    """No such page is an entry of the navigation, so those of one depth have the same links."""

    def __init__(self) -> None:
        self._found: dict[tuple[Any, ...], str] = {}

    def share(self, app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
        """Replace what builds the navigation of a page (`html-page-context`)."""
        if page.startswith("_modules/") and "toctree" in context:
            context["toctree"] = self._remembered(page.count("/"), context["toctree"])

    def _remembered(self, depth: int, build: Callable[..., str]) -> Callable[..., str]:
        def navigation(**options: Any) -> str:
            key = depth, *sorted(options.items())
            if key not in self._found:
                self._found[key] = build(**options)
            return self._found[key]

        return navigation


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("html-page-context", SharedNavigation().share, priority=BEFORE_THE_THEME)
    return {"parallel_read_safe": True}
