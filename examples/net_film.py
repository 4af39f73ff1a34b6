"""The thrown net as a film: results/examples/thrown_net.gif."""

from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

import picture
import thrown_net
from animation import FRAMES, RATE
from style import styled_figure


def main(frames: int = FRAMES) -> None:
    picture.FOLDER.mkdir(parents=True, exist_ok=True)
    motion = thrown_net.run()
    chosen = np.linspace(0, len(motion.times) - 1, frames).round().astype(int)
    with styled_figure(4.5, 4.5) as figure:
        axes: Any = figure.add_subplot(projection="3d")

        def show(frame: int) -> None:
            axes.clear()
            motion.show(axes, chosen[frame])

        film = FuncAnimation(figure, show, frames)
        film.save(picture.FOLDER / "thrown_net.gif", PillowWriter(RATE), dpi=70)


if __name__ == "__main__":
    main()
