"""One look for all pictures: colour-blind-safe (Okabe, Ito), units at the axes, no display."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

try:
    from cycler import cycler
    from matplotlib import rc_context
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image as Image
except ImportError as error:
    missing = "examples draw with Matplotlib, not installed here: pip install 'exudyn_inext[studies]'"
    raise ImportError(missing, name=error.name) from None

COLORS = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000",
    "#882255", "#999933", "#332288",  # of Paul Tol's, where that many are needed
)  # fmt: skip
REFERENCE_COLOR = "#999999"

_STYLE: Any = {
    "axes.prop_cycle": cycler(color=COLORS),
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#e0e0e0",
    "grid.linewidth": 0.6,
    "font.size": 10,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.4,
    "figure.constrained_layout.use": True,
}


@contextmanager
def new_figure(path: Path, width: float = 8.0, height: float = 5.0) -> Iterator[Figure]:
    """A figure of that size [inch] which is saved to `path` (PNG) when the block ends."""
    with styled_figure(width, height) as figure:
        yield figure
        figure.savefig(path, dpi=150)


@contextmanager
def styled_figure(width: float, height: float) -> Iterator[Figure]:
    """A figure of that size [inch] for what is not a single picture: the style holds within the block."""
    with rc_context(_STYLE):
        figure = Figure(figsize=(width, height))
        FigureCanvasAgg(figure)
        yield figure


def label_axes(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Labels with units, e.g. "time t [s]"."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, loc="left", fontsize=10)
