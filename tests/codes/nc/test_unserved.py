"""Services that are not served: each once, none of them a row."""

from collections import Counter

import pytest

from achse.codes.nc.table import every_row
from achse.codes.nc.unserved import OF_AXES, OF_CHANNELS_AND_GROUPS


@pytest.mark.parametrize("table", [OF_AXES, OF_CHANNELS_AND_GROUPS])
def test_none_is_listed_twice(table: dict[str, tuple[tuple[int, int, str, str], ...]]) -> None:
    listed = [service for services in table.values() for service in services]
    assert len(listed) > 10
    assert [each for each, count in Counter(listed).items() if count > 1] == []


def test_none_of_channels_and_groups_is_a_row() -> None:
    served = {(group, row.offset, row.access.replace(" ", "")) for group, row in every_row()}
    listed = [each[:3] for services in OF_CHANNELS_AND_GROUPS.values() for each in services]
    assert [each for each in listed if each in served] == []
