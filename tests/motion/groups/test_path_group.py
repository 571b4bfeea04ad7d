"""3D groups: their places."""

from typing import Any

from achse.codes import NcError


def test_auxiliary_axes_need_a_main_axis(make_groups: Any) -> None:
    rig = make_groups()
    assert rig.path.assign([0, 0, 0, 1]) == NcError.AUXILIARY_AXIS_COUNT
    assert rig.path.assign([0, 2, 0, 1]) == 0
    assert rig.path.remove(rig.axis(2)) == NcError.AUXILIARY_AXIS_COUNT
    assert rig.path.dissolve() == 0
