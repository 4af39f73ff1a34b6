"""The build fails if a page would load anything from the network: scripts, styles, fonts, pictures."""

import re
from pathlib import Path
from typing import Any

from sphinx.errors import ExtensionError

LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed)\b[^>]*\bsrc\s*=\s*["']?(?:https?:)?//[^"'\s>]+"""
    r"""|<link\b(?=[^>]*\brel\s*=\s*["']?(?:stylesheet|preload|icon|shortcut icon|preconnect))"""
    r"""[^>]*\bhref\s*=\s*["']?(?:https?:)?//[^"'\s>]+"""
    r"""|(?:@import\s+|url\()\s*["']?(?:https?:)?//[^"')\s]+""",
    re.IGNORECASE,
)


def remote_resources(text: str) -> list[str]:
    """What a page or style sheet asks the network for when it is shown; links to follow do not count."""
    return [found[0] for found in LOADED.finditer(text)]


def check(app: Any, exception: Exception | None) -> None:
    """Look at every page and style sheet that was written.

    Raises:
        ExtensionError: one of them loads something.
    """
    if exception is not None or app.builder.format != "html":
        return
    for path in sorted(Path(app.outdir).rglob("*")):
        if path.suffix in {".html", ".css"}:
            loads = remote_resources(path.read_text(encoding="utf-8"))
            if loads:
                raise ExtensionError(f"{path.name} loads from the network: {', '.join(loads)}")


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("build-finished", check)
    return {"parallel_read_safe": True}
