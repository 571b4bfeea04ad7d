"""What a group can be."""

from typing import Any

import pytest

from achse.motion.groups.parameters import GroupParameters, GroupParametersError
from achse.motion.groups.states import GroupType


@pytest.mark.parametrize(
    ("name", "value"),
    [("group_id", 0), ("dimension", 17), ("length", 10_001), ("table_size", 127)],
)
def test_ranges(name: str, value: int) -> None:
    options: dict[str, Any] = {"group_id": 9, "type": GroupType.FIFO, "channel_id": 1, name: value}
    with pytest.raises(GroupParametersError, match="expected"):
        GroupParameters(**options)
