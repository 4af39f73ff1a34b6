"""What implements no protocol, or is not known by its name, is refused with its type or name."""

import numpy as np
import pytest

from exudyn_inext import called_system
from exudyn_inext.cable.linear_response import respond
from exudyn_inext.errors import InputError
from exudyn_inext.integrators import find_integrator
from exudyn_inext.integrators.integrator import advance
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates

pytestmark = pytest.mark.kernel

PROTOCOLS = {
    index_reduced_rates: 5,
    accelerate_and_project: 6,
    correct_position: 5,
    respond: 3,
    advance: 6,
}


@pytest.mark.parametrize("protocol", PROTOCOLS, ids=lambda protocol: protocol.__name__)
def test_a_system_of_another_type_is_refused(protocol):
    with pytest.raises(NotImplementedError, match=f"no {protocol.__name__} for str"):
        protocol("no system", *[np.zeros(1)] * PROTOCOLS[protocol])


def test_places_of_addresses_do_not_depend_on_what_is_imported_first(monkeypatch):
    """Kernels in the cache contain them; with others, frequencies were no numbers."""
    before = {protocol: entry.place for protocol, entry in called_system._ENTRIES.items()}
    monkeypatch.setattr(called_system, "_ENTRIES", {})
    for protocol, place in reversed(before.items()):
        assert called_system.by_address(protocol) == place


def test_an_unknown_integrator_is_refused_with_those_that_there_are():
    assert find_integrator("RATTLE").name == "RATTLE"
    with pytest.raises(InputError, match=r"integrator = 'Euler' is unknown: choose one of .*'RATTLE'"):
        find_integrator("Euler")
