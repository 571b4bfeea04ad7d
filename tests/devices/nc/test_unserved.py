"""Services of channels and groups that are not served: each once, none of them a row."""

from collections import Counter
from typing import Any

from achse.devices.nc.unserved import OF_CHANNELS_AND_GROUPS


def test_none_is_served_and_none_listed_twice(bench: Any) -> None:
    served = {
        (row.index_group, row.index_offset, str(row.access).replace("R W", "RW"))
        for row in bench.device.services.describe()
    }
    listed = [service for services in OF_CHANNELS_AND_GROUPS.values() for service in services]
    assert len(listed) > 10
    assert [each for each, count in Counter(listed).items() if count > 1] == []
    assert [each for each in listed if each[:3] in served] == []
