"""Rows of an interpreter are for channels that have one."""

from typing import Any

import pytest

from achse.ams import DeviceError
from achse.devices.nc.channels.binding import of_interpreter
from achse.devices.nc.layouts import LineText


def test_who_has_an_interpreter(groups: Any) -> None:
    channels = groups.nc.channels
    assert of_interpreter(channels.channel(1)) is channels.channel(1)
    for id in (2, 3, 4):
        with pytest.raises(DeviceError):
            of_interpreter(channels.channel(id))


def test_texts_end_with_nul() -> None:
    text = LineText()
    assert text.encode("Ä€\u4e00") == b"\xc4\x80?\0"
    assert text.decode(b"ab\0cd") == "ab"
    assert text.decode(b"ab") == "ab"
