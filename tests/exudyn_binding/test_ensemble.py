"""Ensembles: every member moves as it would alone, on any number of threads; what must not differ."""

import exudyn
import numpy as np
import pytest

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    ExplicitSettings,
    InextensibleCable,
    SolveEnsemble,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import hang, load_node

END = 0.3
TABLE = {"x": (0.0, 0.3), "y": (-0.2, 0.1)}


def pendulum(stiffness=0.0866, tip_speed=0.0, elements=5, build=lambda mbs, nodes: None, **changes):
    """An assembled pendulum; `build` adds to it."""
    mbs = exudyn.SystemContainer().AddSystem()
    velocity = [0.0, tip_speed, 0.0]
    arguments = {
        "shape": CableShape.Line([0, 0, 0], [1.8, 0, 0], elements, velocityEnd=velocity),
        "beamTemplate": InextensibleCable(0.0348, stiffness, **changes.pop("section", {})),
        "gravity": [0, -9.81, 0],
        "groundConstraintsStart": [True, True, False, False],
    } | changes
    nodes = CreateInextensibleCable(mbs, **arguments)["nodes"]
    build(mbs, nodes)
    mbs.Assemble()
    return mbs


def ring(stiffness):
    """A ring that swings on its first node."""
    shape = CableShape.Circle([0, 0], 0.5, 8)
    return pendulum(stiffness, shape=shape)


def pushed(strength):
    """A force on the tip that depends on the time."""

    def force(mbs, t, load):
        return [0.0, strength * np.sin(10.0 * t), 0.0]

    force.dependsOnTimeOnly = True
    return pendulum(build=lambda mbs, nodes: load_node(mbs, nodes[-1], [0] * 3, loadVectorUserFunction=force))


def shaken(amplitude):
    """The first node follows a motion."""

    def position(t):
        return [amplitude * (1.0 - np.cos(6.0 * t)), 0.0]

    return pendulum(
        build=lambda mbs, nodes: CreatePrescribedMotion(mbs, nodes[0], position), groundConstraintsStart=None
    )


def hung(height):
    """The first node hangs on a rod."""
    return pendulum(
        build=lambda mbs, nodes: hang(mbs, nodes[0], [0, height, 0], height), groundConstraintsStart=None
    )


def two_cables(stiffness):
    """Two cables whose steps are bounded alike."""
    mbs = pendulum(stiffness)
    CreateInextensibleCable(mbs, [0, 1, 0], [1.8, 1, 0], 4, InextensibleCable(0.0348, stiffness))
    mbs.Assemble()
    return mbs


def spatial(speed):
    return pendulum(
        dimension=3,
        groundConstraintsStart=[True] * 3 + [False] * 3,
        shape=CableShape.Line([0, 0, 0], [1.8, 0, 0], 5, velocityEnd=[0, 0, speed]),
    )


def moved(mbs, h, **explicit):
    """(3, n) last coordinates, velocities and accelerations of a run of its own."""
    with silence():
        SolveExplicit(mbs, quiet_settings(END, 1), ExplicitSettings(stepSize=h, **explicit))
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def ensemble(build, parameters, threads=1, derivatives=2, **explicit):
    return SolveEnsemble(
        build, quiet_settings(END, 1), ExplicitSettings(**explicit), parameters, derivatives, threads
    )


def last(result):
    """(members, 3, n)"""
    return np.stack([result[name][:, -1] for name in ("coordinates", "velocities", "accelerations")], axis=1)


@pytest.mark.parametrize(
    ("build", "parameters", "explicit"),
    [
        (pendulum, [0.05, 0.0866, 0.1], {}),
        (pendulum, [0.05, 0.0866, 0.1], {"integrator": "Zhai"}),
        (pendulum, [0.05, 0.0866], {"stepSize": 5e-3, "massScaling": 0.3}),
        (pushed, [0.1, 0.2], {}),
        (shaken, [0.1, 0.2], {}),
        (hung, [0.3, 0.5], {}),
        (ring, [0.05, 0.0866], {}),
        (two_cables, [0.05, 0.0866], {}),
        (spatial, [0.0, 0.5], {}),
    ],
)
def test_every_member_moves_bit_for_bit_as_it_does_alone(build, parameters, explicit):
    result = ensemble(build, parameters, **explicit)
    assert result["status"] == ["ok"] * len(parameters)
    alone = dict(explicit, stepSize=result["stepSize"])
    alone = {"integrator": alone.pop("integrator", "RATTLE")} | alone
    h = alone.pop("stepSize")
    for member, values in zip(last(result), parameters, strict=True):
        np.testing.assert_array_equal(member, moved(build(values), h, **alone))
    assert np.abs(np.diff(last(result), axis=0)).max() > 1e-3  # the parameters matter
