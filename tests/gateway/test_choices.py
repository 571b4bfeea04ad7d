"""A client of a gateway chooses at port 1 for its connection."""

from typing import Any

import pytest

from achse.ams import DeviceError
from achse.gateway.choices import RESUBSCRIBE, resubscribe_group
from achse.router.forwarding.resubscription import Resubscription


@pytest.mark.parametrize("wanted", [False, True])
def test_one_byte_is_the_choice_of_the_connection(wanted: bool) -> None:
    way: Any = type("Way", (), {})()
    choices = Resubscription()
    group = resubscribe_group(choices, lambda: way)
    for size in (0, 2):
        with pytest.raises(DeviceError, match=f"expected 1 byte, got {size}"):
            group.read_write(RESUBSCRIBE, 0, 1, bytes(size), b"")
    data = bytes([wanted])
    assert group.read_write(RESUBSCRIBE, 0, 1, data, b"") == data
    assert choices.applies(way, bytes(8), not wanted) is wanted


def test_without_a_connection_there_is_no_choice() -> None:
    group = resubscribe_group(Resubscription(), lambda: None)
    with pytest.raises(DeviceError, match="no connection"):
        group.read_write(RESUBSCRIBE, 0, 1, b"\1", b"")
