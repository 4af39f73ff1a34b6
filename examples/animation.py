"""The four scenes of the paper side by side, as a GIF: results/examples/four_scenes.gif."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure

import picture
import planar_pendulum
import power_line
import spatial_pendulum
import vibrating_ring
from shapes import frame_axes, smooth
from style import COLORS, REFERENCE_COLOR, styled_figure

SCENES = {
    "planar pendulum": planar_pendulum,
    "spatial pendulum": spatial_pendulum,
    "vibrating ring": vibrating_ring,
    "power line after ice shedding": power_line,
}
FRAMES, RATE, TRAIL = 60, 12, 10  # number, per second; frames


def motion(example: Any) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s], and nodal positions (n, k, 3) [m], of an example run as it is."""
    shown: list[Any] = []
    example.main(show=lambda name, times, cables, *others: shown.extend((times, cables[0])))
    return shown[0], shown[1]


def panel(figure: Figure, place: int, name: str, example: Any) -> Callable[[int], None]:
    """Draw one scene's axes; returns what draws a frame into them."""
    times, points = motion(example)
    space = 3 if np.ptp(points[:, :, 2]) else 2
    chosen = np.linspace(0, len(times) - 1, FRAMES).round().astype(int)
    axes: Any = figure.add_subplot(2, 2, place, projection="3d" if space == 3 else None)
    frame_axes(axes, points[:, :, :space])
    (trail,) = axes.plot(*points[0, :1, :space].T, color=REFERENCE_COLOR)
    (cable,) = axes.plot(*points[0, :, :space].T, color=COLORS[0], linewidth=2)
    observed = {power_line: power_line.ELEMENTS // 4, vibrating_ring: 0}.get(example, -1)

    def show(frame: int) -> None:
        now = chosen[frame]
        path = points[chosen[max(0, frame - TRAIL)] : now + 1, observed]
        for line, drawn in ((cable, smooth(points[now])), (trail, path)):
            (line.set_data if space == 2 else line.set_data_3d)(*drawn.T[:space])
        axes.set_title(f"{name}, t = {times[now]:.2f} s", loc="left", fontsize=10)

    return show


def main() -> None:
    picture.FOLDER.mkdir(parents=True, exist_ok=True)
    with styled_figure(9.0, 5.6) as figure:
        panels = [panel(figure, k, *scene) for k, scene in enumerate(SCENES.items(), start=1)]

        def show_all(frame: int) -> None:
            [show(frame) for show in panels]

        show_all(0)
        figure.canvas.draw()
        figure.set_layout_engine("none")  # as it is now, in all frames
        film = FuncAnimation(figure, show_all, FRAMES)
        film.save(picture.FOLDER / "four_scenes.gif", PillowWriter(RATE), dpi=80)


if __name__ == "__main__":
    main()
