"""One picture for each example: snapshots of cables and bodies, and one quantity over time."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import SensorNode

from outlines import outline
from shapes import is_flat, smooth
from style import COLORS, Image, label_axes, new_figure

FOLDER = Path("results/examples")
SNAPSHOTS = 6


def sense(mbs: Any, nodes: Sequence[int]) -> list[int]:
    """Position sensors of nodes."""
    kind = exu.OutputVariableType.Position
    return [
        mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))
        for node in nodes
    ]


def paths(mbs: Any, sensors: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and positions (n, k, 3) [m] of k sensors."""
    stored = np.stack([mbs.GetSensorStoredData(sensor) for sensor in sensors], axis=1)
    return stored[:, 0, 0], stored[:, :, 1:]


def draw(
    name: str,
    times: np.ndarray,
    cables: Sequence[np.ndarray],
    plane: str,
    curves: dict[str, np.ndarray],
    quantity: str,
    bodies: Sequence[np.ndarray] = (),
) -> None:
    """Save results/examples/<name>.png.

    Args:
        name: of the example.   times: (n,) [s].   cables: nodal positions (n, k, 3) [m] of each.
        plane: which axes the snapshots show, such as "xz".
        curves: label -> (n,) over time.   quantity: their name and unit.
        bodies: points (n, k, 3) [m] of each, of which the outline is drawn.
    """
    FOLDER.mkdir(parents=True, exist_ok=True)
    path, axes = FOLDER / f"{name}.png", ["xyz".index(axis) for axis in plane]
    with new_figure(path, 7.5, 3.2) as figure:
        scene, history = figure.subplots(1, 2)
        for place, k in enumerate(np.linspace(0, len(times) - 1, SNAPSHOTS).round().astype(int)):
            shade = 0.2 + 0.8 * place / (SNAPSHOTS - 1)
            for body in bodies:
                scene.fill(*outline(body[k][:, axes]).T, color=COLORS[1], alpha=0.3 * shade, linewidth=0)
            for number, cable in enumerate(cables):
                line = smooth(cable[k])[:, axes].T
                label = None if number else f"t = {times[k]:.2g} s"
                scene.plot(*line, color=COLORS[0], alpha=shade, label=label)
        if not is_flat(cables):
            scene.set_aspect("equal", adjustable="datalim")
        scene.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
        label_axes(scene, f"{plane[0]} [m]", f"{plane[1]} [m]")
        for label, values in curves.items():
            history.plot(times, values, label=label)
        narrow = {"columnspacing": 1.0, "handlelength": 1.2}
        history.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=3, **narrow)
        label_axes(history, "time t [s]", quantity)
    shrink(path)


def shrink(path: Path) -> None:
    """Store a picture with a palette, a third of the size, and say where it is."""
    Image.open(path).convert("RGB").quantize(64).save(path, optimize=True)
    print(f"picture: {path.resolve()}")
