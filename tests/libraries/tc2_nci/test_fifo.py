"""Blocks of FIFO axes: the channel's group is asked for, then comes the command."""

import struct

import pytest

from achse.codes import NcError
from tests.libraries.tc2_nci.conftest import NciBench

CHANNEL = 4


@pytest.fixture
def fifo(nci: NciBench) -> NciBench:
    for axis, place in ((5, 1), (6, 2)):
        inputs = {"iAxisId": axis, "iGroupPosition": place}
        assert nci.fire("FiFoGroupIntegrate", iChannelId=CHANNEL, **inputs) == 0
    return nci


def _rows(fifo: NciBench, rows: list[tuple[float, float]], name: str = "FiFoWrite") -> int:
    for n, value in enumerate(each for row in rows for each in row):
        fifo.main["numbers"][n] = value
    return fifo.fire(name, iChannelId=CHANNEL, iColDim=2, iRowsToWrite=len(rows))


def test_requests(nci: NciBench) -> None:
    look = ("R", 0x2004, 0x21, 4)
    nci.fire("FiFoGroupIntegrate", iChannelId=CHANNEL, iAxisId=5, iGroupPosition=2)
    assert nci.requests() == [look, ("W", 0x3214, 0x51, struct.pack("<II", 5, 1))]
    _rows(nci, [(1.0, 2.0), (3.0, 4.0)])
    assert nci.requests() == [look, ("W", 0x3214, 0x710, struct.pack("<4d", 1.0, 2.0, 3.0, 4.0))]
    _rows(nci, [(1.0, 2.0)], "FiFoOverwrite")
    assert nci.requests() == [look, ("W", 0x3214, 0x711, struct.pack("<2d", 1.0, 2.0))]
    for name, offset in (
        *(("FiFoStart", 0x701), ("FiFoStop", 0x02), ("FiFoGroupDisintegrate", 0x53)),
    ):
        nci.fire(name, iChannelId=CHANNEL)
        assert nci.requests() == [look, ("W", 0x3214, offset, b"")]


def test_rows_are_followed(fifo: NciBench) -> None:
    assert fifo.fire("FiFoGetDimension", iChannelId=CHANNEL) == 0
    block = fifo.main["aFiFoGetDimension"]
    assert block["iNoOfAxes"] == 2
    assert block["iNoOfFifoEntries"] > 0
    assert _rows(fifo, [(n / 100, n / 50) for n in range(101)]) == 0
    assert fifo.fire("FiFoSetChannelOverride", iChannelId=CHANNEL, iOverride=1_000_000) == 0
    assert fifo.fire("FiFoStart", iChannelId=CHANNEL) == 0
    fifo.call(300)
    assert [fifo.nc.axis(n).set_position for n in (5, 6)] == [1.0, 2.0]
    assert fifo.fire("FiFoStop", iChannelId=CHANNEL) == 0
    fifo.call(10)
    assert fifo.fire("FiFoGroupDisintegrate", iChannelId=CHANNEL) == 0


def test_what_is_refused(fifo: NciBench) -> None:
    most = {"iChannelId": CHANNEL, "iColDim": 2, "iRowsToWrite": 1}
    for wrong in ({"iColDim": 0}, {"iColDim": 17}, {"iRowsToWrite": 0}, {"iRowsToWrite": 10_001}):
        for name in ("FiFoWrite", "FiFoOverwrite"):
            assert fifo.fire(name, **{**most, **wrong}) == NcError.PLC_PARAMETER
            assert fifo.requests() == []
    place = {"iAxisId": 5, "iGroupPosition": 0}
    assert fifo.fire("FiFoGroupIntegrate", iChannelId=CHANNEL, **place) == NcError.PLC_PARAMETER
    for name in ("FiFoStart", "FiFoStop", "FiFoGroupDisintegrate", "FiFoGetDimension"):
        assert fifo.fire(name, iChannelId=0) == NcError.PLC_CHANNEL_NOT_READY
        assert fifo.fire(name, iChannelId=77) == NcError.CHANNEL_ID
    number = fifo.fire("FiFoSetChannelOverride", iChannelId=CHANNEL, iOverride=1_000_001)
    assert number == NcError.OVERRIDE_INVALID
    assert fifo.fire("FiFoStart", iChannelId=1) != 0  # the group of a part program is no FIFO
