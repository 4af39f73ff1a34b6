"""Cables and a ball in space: snapshots, and frames of a film."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import SensorBody

import exudyn_inext as inext
import picture
from shapes import smooth
from style import COLORS, new_figure

TICKS = [-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5]  # [m]


@dataclass(frozen=True)
class Motion:
    """times: (n,) [s].   cables: nodal positions (n, k, 3) [m] of each.   ball: (n, 3) its centre [m].

    velocity: (n, 3) of the ball [m/s].   radius: of it [m].
    """

    times: np.ndarray
    cables: Sequence[np.ndarray]
    ball: np.ndarray
    velocity: np.ndarray
    radius: float

    def show(self, axes: Any, now: int) -> None:
        """One instant; the axes follow the ball along z."""
        u, v = np.mgrid[0 : 2 * np.pi : 17j, 0 : np.pi : 9j]
        sphere = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
        surface = self.ball[now][:, None, None] + self.radius * sphere
        axes.plot_surface(*surface, color=COLORS[1], alpha=0.5, linewidth=0)
        for cable in self.cables:
            axes.plot(*smooth(cable[now]).T, color=COLORS[0], linewidth=0.8)
        height = self.ball[now, 2]
        axes.set(xlim=(-0.8, 0.8), ylim=(-0.8, 0.8), zlim=(height - 0.9, height + 0.7))
        axes.set(xticks=TICKS[1:4], yticks=TICKS[1:4], zticks=[t for t in TICKS if abs(t - height) < 0.8])
        for axis in "xyz":
            getattr(axes, f"set_{axis}label")(f"{axis} [m]", fontsize=6, labelpad=-8)
        axes.tick_params(labelsize=6, pad=-2)
        axes.set_box_aspect((1, 1, 1), zoom=1.2)
        axes.view_init(12, -60)
        said = f"t = {self.times[now]:.2f} s, ball at {self.velocity[now, 2]:.1f} m/s"
        axes.set_title(said, fontsize=7, y=0.98)

    def snapshots(self, name: str, instants: Sequence[float]) -> Path:
        """Save results/examples/<name>.png.   instants: six [s]."""
        picture.FOLDER.mkdir(parents=True, exist_ok=True)
        path = picture.FOLDER / f"{name}.png"
        with new_figure(path, 6.6, 4.2) as figure:
            figure.get_layout_engine().set(h_pad=0.15, w_pad=0.15)  # room for labels of axes in space
            for number, t in enumerate(instants, start=1):
                now = int(np.argmin(np.abs(self.times - t)))
                self.show(figure.add_subplot(2, 3, number, projection="3d"), now)
        picture.shrink(path)
        return path


def record(mbs: Any, scene: dict[str, Any], radius: float, end_time: float, explicit: Any) -> Motion:
    """Run a scene whose first body is a ball of that radius [m], until end_time [s]."""
    kinds = exu.OutputVariableType.Position, exu.OutputVariableType.Velocity
    cables = [picture.sense(mbs, cable["nodes"]) for cable in scene["cables"]]
    ball = [
        mbs.AddSensor(SensorBody(bodyNumber=scene["bodies"][0], storeInternal=True, outputVariableType=kind))
        for kind in kinds
    ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = end_time
    print(inext.SolveExplicit(mbs, settings, explicit)["path"])
    (times, way), (_, velocity) = (picture.paths(mbs, [sensor]) for sensor in ball)
    of_cables = [picture.paths(mbs, sensors)[1] for sensors in cables]
    return Motion(times, of_cables, way[:, 0], velocity[:, 0], radius)
