"""What is left out where a user function acts between steps, and that it changes nothing."""

import numpy as np
import pytest

from exudyn_inext.compiled import Prepared
from exudyn_inext.lowered import _kinds
from exudyn_inext.run.kept_state import KeptState
from tests.exudyn_binding.test_changes_between_steps import (
    deviation,
    driven_mass,
    force_on_a_node,
    moved,
    moving_support,
    name_of,
    spring_and_force,
    winch,
)


def winch_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return winch(model)


@pytest.mark.parametrize("kind", [driven_mass, moving_support, winch, winch_beside_a_mass], ids=name_of)
def test_joints_that_are_moved_stay_in_compiled_code(kind):
    ours, native = (moved(kind, is_native, end_time=0.3) for is_native in (False, True))
    assert "Exudyn evaluates" not in ours.report["path"]
    assert deviation(ours.motion, native.motion) < 0.003


def stop_that_is_set_before_it_acts(model):
    """Its place is set at each step, long before it is switched on."""
    node, _ = model.mass_point([1.8, 0, 0])
    stop = model.hold(node, 1, active=False)

    def change(t):
        if t < 0.2:
            model.set_object(stop, offset=float(model.position(node)[1]))
        model.set_object(stop, activeConnector=t > 0.2)

    return change


def test_the_place_of_a_joint_may_be_set_before_it_is_switched_on():
    ours, native = (
        moved(stop_that_is_set_before_it_acts, is_native, end_time=0.3) for is_native in (False, True)
    )
    assert deviation(ours.motion, native.motion) < 0.01


@pytest.mark.parametrize("kind", [force_on_a_node, spring_and_force, driven_mass], ids=name_of)
def test_kernels_are_called_with_the_types_that_they_are_prepared_for(kind, monkeypatch):
    call, first, calls = Prepared.__call__, {}, []

    def checked(self, *arguments):
        kinds = _kinds(arguments)
        assert first.setdefault(self, kinds) == kinds
        calls.append(self)
        return call(self, *arguments)

    monkeypatch.setattr(Prepared, "__call__", checked)
    moved(kind, False, end_time=0.05)
    assert len(calls) >= 100


def test_a_state_is_kept_whatever_the_gaps_between_its_numbers():
    whole = np.arange(60.0).reshape(3, 4, 5)
    records = np.zeros(4, [("a", np.int64), ("b", np.float64, (2,))])
    records["b"] = np.arange(8.0).reshape(4, 2)
    arrays = {
        "gaps": whole[:, ::2, 1:3],
        "whole": np.arange(3),
        "part": {"b": records["b"], "none": whole[:0]},
    }
    kept, before = KeptState(arrays), whole.copy()
    whole[:], records["b"] = -1.0, -1.0
    arrays["whole"][:] = -1
    kept.restore()
    np.testing.assert_array_equal(whole[:, ::2, 1:3], before[:, ::2, 1:3])
    assert (whole[:, 1::2] == -1.0).all()
    np.testing.assert_array_equal(records["b"].ravel(), np.arange(8.0))
    np.testing.assert_array_equal(arrays["whole"], np.arange(3))
    records["b"] = 5.0
    kept.keep()
    records["b"] = 6.0
    kept.restore()
    assert (records["b"] == 5.0).all()
