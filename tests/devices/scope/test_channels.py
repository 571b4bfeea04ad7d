"""Channels: any symbol or row of any device, and what a scope cannot have."""

from pathlib import Path
from typing import Any

import pytest

from achse.devices.scope.channels import NOT_SCOPED, ScopeChannels
from achse.scope import ScopeError, channel_of
from achse.station import Station


@pytest.fixture(scope="module")
def station() -> Station:
    return Station.demo()


@pytest.fixture
def channels(station: Station) -> ScopeChannels:
    return ScopeChannels(lambda: station.devices, 851)


@pytest.mark.parametrize(
    ("words", "type", "cycle_ms"),
    [
        ("MAIN.nCounter", "UINT32", 10),
        ("500:Axes.X.ActPos", "REAL64", 2),
        ("501:Axes.Y.SetPos", "REAL64", 2),
        ("500:0x4101:0x0A", "REAL64", 2),
        ("500:0x4101:0x0A:INT16", "INT16", 2),
        ("851:0x4020:0:UINT8", "UINT8", 10),
        ("14000:0x1000:1", "UINT8", 10),
        ("10000:0xF100:0:UINT16", "UINT16", 10),
    ],
)
def test_rows_and_symbols_of_any_device_are_found(
    channels: ScopeChannels, words: str, type: str, cycle_ms: int
) -> None:
    source = channels.find(channel_of(words))
    assert (source.type.name, source.cycle_ns) == (type, cycle_ms * 1_000_000)
    assert len(source.read()) >= source.type.size


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("MAIN.nCountr", "port 851 has no symbol 'MAIN.nCountr'; did you mean 'MAIN.nCounter'?"),
        ("852:MAIN.n", "no device at port 852, there are 1, 30, 100, 110, 200, 500, 501, 851"),
        ("10000:MAIN.n", "the device at port 10000 has no symbols"),
        ("500:Axes.X.ToPlc", "expected a number or a BOOL, Axes.X.ToPlc is a NCTOPLC_AXIS_REF"),
        ("500:0x4109:0x0A", "id 9"),
        ("500:0x4101:0xFFFF", "0x4101:0xFFFF"),
        ("500:0x4200:1", "expected a type"),
        ("851:0x4020:0", r"expected a type \(BIT, INT8"),
        ("500:0x1000:0x10:REAL64", "a REAL64 has 8 bytes, the value 4"),
    ],
)
def test_what_is_not_a_value_is_reported(channels: ScopeChannels, words: str, message: str) -> None:
    with pytest.raises(ScopeError, match=message):
        channels.find(channel_of(words))


LISTED = Path(__file__).parents[2] / "data" / "nc_not_scoped.tsv"


def places() -> list[tuple[int, int]]:
    lines = LISTED.read_text(encoding="utf-8").splitlines()[1:]
    return [(int(group, 16), int(offset, 16)) for group, offset in (x.split("\t") for x in lines)]


@pytest.mark.parametrize(("group", "offset"), places())
def test_what_the_manual_says_is_not_for_a_scope_is_refused(
    channels: ScopeChannels, group: int, offset: int
) -> None:
    """The marks of 002 §6.4."""
    own = group if group in (0x1100,) else group + 1
    with pytest.raises(ScopeError, match="a scope cannot have this value"):
        channels.find(channel_of(f"500:0x{own:X}:0x{offset:X}:REAL64"))


def test_the_list_is_that_of_the_manual() -> None:
    ours: Any = {
        (group, offset)
        for group, offsets in NOT_SCOPED.items()
        for offset in offsets
        if not 0x1000_0000 < offset < 0x1000_0000 + 1000
    }
    assert ours == set(places())


def test_sub_elements_are_meant_too(channels: ScopeChannels) -> None:
    with pytest.raises(ScopeError, match="a scope cannot have this value"):
        channels.find(channel_of("500:0x4101:0x00120003"))
