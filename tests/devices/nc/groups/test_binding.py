"""Finding groups by id, and the group of an axis."""

from typing import Any

import pytest

from achse.ams import DeviceError
from achse.devices.nc.groups.binding import GroupFinder, group_of


def test_every_group_has_its_id(groups: Any) -> None:
    finder = GroupFinder(groups.nc)
    assert finder.ids() == [1, 2, 3, 4, 11, 12, 13]
    assert [finder.find(id).group_id for id in finder.ids()] == finder.ids()
    with pytest.raises(DeviceError, match="id 5"):
        finder.find(5)
    data = groups.read(0x1100, 0x32, 1020)
    assert [int.from_bytes(data[n : n + 4], "little") for n in range(0, len(data), 4)] == (
        finder.ids()
    )


def test_the_group_of_an_axis_is_where_it_is_now(groups: Any) -> None:
    axis = groups.nc.axis(2)
    assert group_of(axis).group_id == 2
    groups.put(0x320B, 0x50, "<3I", 2, 0, 0)
    assert group_of(axis).group_id == 11
