"""Native templates are read under the names of all of Exudyn's versions."""

import exudyn
import pytest
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D, ObjectBeamGeometricallyExact2D

from exudyn_inext import CreateInextensibleCable, InextensibleCable
from exudyn_inext.errors import InputError

VALUES = {"massPerLength": 2.0, "bendingStiffness": 3.0, "bendingDamping": 0.1}
AXIAL = {"axialStiffness": 5.0, "axialDamping": 0.2, "referenceAxialStrain": 0.01}


def older(values):
    return {f"physics{name[0].upper()}{name[1:]}": value for name, value in values.items()}


@pytest.mark.parametrize("template", [ObjectANCFCable, ObjectANCFCable2D])
@pytest.mark.parametrize("names", [dict, older])
def test_a_native_template_brings_all_of_its_values(template, names):
    curvature = {"referenceCurvature": 0.5} if template is ObjectANCFCable2D else {}
    native = template(**names({**VALUES, **AXIAL, **curvature}))
    read = InextensibleCable.from_template(native, extensible=True)
    assert read == InextensibleCable(**VALUES, **AXIAL, **curvature)


@pytest.mark.parametrize("share", [False, True])
def test_scripts_say_a_share_of_strain_by_true_and_false(share):
    native = ObjectANCFCable2D(**VALUES, **AXIAL, strainIsRelativeToReference=share)
    read = InextensibleCable.from_template(native, extensible=True)
    assert read.section(2).strain_is_relative == float(share)


def test_a_prestretched_belt_is_refused_until_the_remedy_is_followed():
    """As in Exudyn's belt drives; an inextensible cable has no strain to begin with."""
    belt = ObjectANCFCable2D(**VALUES, axialStiffness=5.0, referenceAxialStrain=-0.002)
    with pytest.raises(InputError, match=r"referenceAxialStrain = -0\.002: .*give extensible=True"):
        InextensibleCable.from_template(belt)
    assert InextensibleCable.from_template(belt, extensible=True).referenceAxialStrain == -0.002


def test_a_native_element_of_another_kind_is_named_and_not_printed():
    with pytest.raises(InputError, match=r"^beamTemplate = ObjectBeamGeometricallyExact2D: must be"):
        InextensibleCable.from_template(ObjectBeamGeometricallyExact2D())


@pytest.mark.parametrize(("template", "size"), [(ObjectANCFCable2D, 4), (ObjectANCFCable, 6)])
def test_a_native_template_decides_whether_a_straight_cable_lies_in_space(template, size):
    mbs = exudyn.SystemContainer().AddSystem()
    cable = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 2, template(**VALUES))
    assert len(mbs.GetNodeParameter(cable["nodes"][0], "referenceCoordinates")) == size
