"""Scenes whose cables are inextensible or native, among bodies, joints and contact: what `coupled` solves.

To add one, add a line to `SCENES`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from examples import capstan, crane, drone, net, slider_crank, tethered_bodies
from examples import overhead_line as line
from examples.meshes import Net, tie
from exudyn_inext import CreateInextensibleCable, InextensibleCable

QUICK: dict[str, Any] = {"end_time": 0.06, "steps": (5e-3, 2e-3)}  # [s]


@dataclass(frozen=True)
class CoupledScene:
    """A scene of cables, and how it is tuned.

    build: (mbs, addCable, elements) -> "cables" with their "nodes", and "bodies".   end_time: [s].
    meshes: numbers of elements that are tried; watched are the nodes that all of them have, and bodies.
    axial, steps: stiffnesses of native cables [N] and steps [s] that are tried.
    fine: elements and step [s] of converged runs.
    settles: whether it starts from its equilibrium, found before.   is_small: enough for dense matrices.
    is_quick: whether a quick run has it.
    """

    name: str
    build: Callable[..., dict[str, Any]]
    end_time: float
    meshes: Sequence[int] = (2, 4, 6, 8, 12)
    axial: Sequence[float] = (1e5, 1e6, 1e7)
    fine: tuple[int, float] = (24, 2e-4)
    steps: Sequence[float] = (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
    settles: bool = False
    is_small: bool = True
    is_quick: bool = False

    def brief(self) -> "CoupledScene":
        """Of a quick run: two meshes and steps, and little motion."""
        meshes = self.meshes[:2]
        return replace(self, meshes=meshes, axial=self.axial[-1:], fine=(meshes[-1], 1e-3), **QUICK)


def overhead_line(spans: int, meshes: Sequence[int], **more: Any) -> CoupledScene:
    """Several spans; the force runs along the first one."""
    name = f"overhead line, {spans * line.DROPPERS} droppers"
    build = partial(line.build, spans=spans)
    own: dict[str, Any] = {"axial": (1e7, 1e8), "fine": (12, 2e-4), "settles": True, "is_small": False}
    return CoupledScene(name, build, 1.2, meshes, **own, **more)


GRAVITY = [0.0, 0.0, -9.81]
SECTION = InextensibleCable(massPerLength=0.2, bendingStiffness=2e-3)
SIDE, SAG = 0.25, 0.15  # of a mesh [m], of the net over its size


class Bowl(Net):
    """A net in the shape of a bowl, from which it is released."""

    def place(self, knot: tuple[int, int]) -> list[float]:
        """[m]"""
        x, y = (k / self.meshes for k in knot)
        depth = 4.0 * SAG * self.meshes * self.mesh
        return [self.mesh * knot[0], self.mesh * knot[1], -depth * (x * (1 - x) + y * (1 - y))]


def _build_net(
    meshes: int, mbs: Any, addCable: Callable[..., Any] = CreateInextensibleCable, elements: int = 6
) -> dict[str, Any]:
    """A cable for each side of a mesh; the corners are held."""
    net = Bowl(meshes, SIDE, 0.0, elements)
    cables, meeting = net.add(mbs, partial(addCable, gravity=GRAVITY), SECTION)
    for knot, nodes in meeting.items():
        corner = [mbs.CreateGround(referencePosition=net.place(knot))] if knot in net.corners else []
        tie(mbs, corner, nodes)
    return {"cables": cables, "bodies": []}


def net_of_squares(meshes: int) -> CoupledScene:
    """meshes: along a side."""
    name, axial = f"net of {2 * meshes * (meshes + 1)} cables", (1e4, 1e5, 1e6)
    build = partial(_build_net, meshes)
    return CoupledScene(name, build, 0.4, (2, 3, 4, 6, 8), axial, (12, 2e-4), is_small=False)


SCENES = (
    CoupledScene("crane", crane.build, 1.0, is_quick=True),
    CoupledScene("tethered bodies", tethered_bodies.build, 1.0),
    CoupledScene("drone", drone.build, 1.4),
    CoupledScene("slider-crank", slider_crank.build, 1.0),
    CoupledScene("capstan", capstan.build, 0.3, (10, 20, 30, 40, 50), (1e5, 1e6), (60, 1e-4)),
    CoupledScene("dropped net", net.build, 0.4, (4, 6, 8, 12), (1e5, 1e6), (16, 2e-4), is_small=False),
    overhead_line(1, (1, 2, 3, 4, 6)),
    overhead_line(3, (1, 2, 4, 6)),
    net_of_squares(2),
    replace(net_of_squares(3), meshes=(2, 3, 4, 6), axial=(1e5, 1e6), steps=(5e-3, 2e-3, 1e-3, 5e-4)),
)
