"""What each block asks the NC for: one request for an edge, to the services that the manual has."""

import struct
from datetime import timedelta
from typing import Any

import pytest

from achse.codes import NcError, ReturnCode
from tests.libraries.tc2_nci.conftest import NciBench, Request, blocks, inputs_of

CHANNEL, GROUP = 1, 11
W, R, RW = "W", "R", "RW"
u16, u32 = struct.Struct("<H").pack, struct.Struct("<I").pack


def _words(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


def _sum(parts: list[tuple[int, int, int]], data: bytes = b"") -> bytes:
    return b"".join(_words(*part) for part in parts) + data


TOOL_ROWS = [(0x2001, 0x2_0300, 2), (0x2001, 0x3_0300, 2)] + [
    (0x2001, 0x4_0300 + n, 8) for n in range(2, 15)
]
G55_ROWS = [(0x2001, 0x1_0103 + 0x100 * axis + part, 8) for axis in range(3) for part in range(2)]
G59_ROWS = [(0x2001, 0x1_010A + 0x100 * axis, 8) for axis in range(3)]

Case = tuple[str, dict[str, Any], Request]

BOTH: tuple[tuple[str, str, dict[str, Any], Request], ...] = (
    ("ItpDelDtgEx", "ItpDelDtg", {}, (W, 0x2201, 0x40, b"")),
    ("ItpGoAheadEx", "ItpGoAhead", {}, (W, 0x2201, 0x30, b"")),
    ("ItpLoadProgEx", "ItpLoadProg", {"sPrg": "a.nc++", "nLength": 4}, (W, 0x2201, 0x04, b"a.nc")),
    ("ItpResetEx2", "ItpReset", {}, (W, 0x2201, 0x10, b"")),
    ("ItpResetEx2", "ItpResetEx", {}, (W, 0x2201, 0x10, b"")),
    ("ItpResetFastMFuncEx", "ItpResetFastMFunc", {"nMFuncNo": 7}, (W, 0x2201, 0x60, u16(7))),
    ("ItpSetSubroutinePathEx", "ItpSetSubroutinePath", {}, (W, 0x2201, 0x06, b"")),
    ("ItpSetToolDescNullEx", "ItpSetToolDescNull", {}, (W, 0x2201, 0x26, b"")),
    ("ItpSetZeroShiftNullEx", "ItpSetZeroShiftNull", {}, (W, 0x2201, 0x27, b"")),
    (
        *("ItpSetBottleNeckLookAheadEx", "ItpSetBottleNeckLookAhead", {"nLookAhead": 9}),
        (W, 0x2001, 0x51, u32(9)),
    ),
    (
        *("ItpSetBottleNeckModeEx", "ItpSetBottleNeckMode", {"eBottleNeckMode": 2}),
        (W, 0x2001, 0x50, u32(2)),
    ),
    ("ItpGetBottleNeckLookAheadEx", "ItpGetBottleNeckLookAhead", {}, (R, 0x2001, 0x51, 4)),
    ("ItpGetBottleNeckModeEx", "ItpGetBottleNeckMode", {}, (R, 0x2001, 0x50, 4)),
    (
        *("ItpEStopEx", "ItpEStop", {"fDec": 5000.0, "fJerk": 9000.0}),
        (W, 0x320B, 0x04, struct.pack("<dd", 5000.0, 9000.0)),
    ),
    ("ItpStepOnAfterEStopEx", "ItpStepOnAfterEStop", {}, (W, 0x320B, 0x06, b"")),
    ("ItpReadToolDescEx", "ItpReadToolDesc", {"nDNo": 3}, (RW, 0xF080, 15, _sum(TOOL_ROWS))),
    (
        *("ItpWriteToolDescEx", "ItpWriteToolDesc", {"nDNo": 3}),
        (RW, 0xF081, 15, _sum(TOOL_ROWS, bytes(2 + 2 + 13 * 8))),
    ),
    ("ItpReadZeroShiftEx", "ItpReadZeroShift", {"nZsNo": 55}, (RW, 0xF080, 6, _sum(G55_ROWS))),
    ("ItpReadZeroShiftEx", "ItpReadZeroShift", {"nZsNo": 59}, (RW, 0xF080, 3, _sum(G59_ROWS))),
    (
        *("ItpWriteZeroShiftEx", "ItpWriteZeroShift", {"nZsNo": 55}),
        (RW, 0xF081, 6, _sum(G55_ROWS, bytes(48))),
    ),
)

ONE: tuple[Case, ...] = (
    ("ItpEnableFeederBackup", {"bEnable": True}, (W, 0x2001, 0x54, u32(1))),
    ("ItpIsFeederBackupEnabled", {}, (R, 0x2001, 0x54, 4)),
    ("ItpRetraceMoveBackward", {}, (W, 0x2201, 0x14, _words(2, 0) + bytes(64))),
    ("ItpRetraceMoveForward", {}, (W, 0x2201, 0x14, _words(1, 0) + bytes(64))),
    ("ItpEnableDefaultGCode", {"bUseDefaultGCode": True}, (W, 0x2001, 0x15, u16(1))),
    (
        *("ItpSetCyclicUDintOffsets", {f"nIndexOffsetParam{n}": n for n in (1, 2, 3, 4)}),
        (W, 0x2001, 0x55, _words(1, 2, 3, 4)),
    ),
    (
        *("ItpSetCyclicLrealOffsets", {f"nIndexOffsetParam{n}": n for n in (1, 2, 3, 4)}),
        (W, 0x2001, 0x56, _words(1, 2, 3, 4)),
    ),
    ("ItpGetCyclicUDintOffsets", {}, (R, 0x2001, 0x55, 16)),
    ("ItpGetCyclicLrealOffsets", {}, (R, 0x2001, 0x56, 16)),
    ("ItpGetBlocksearchData", {}, (R, 0x310B, 0x556, 80)),
    ("ItpStepOnAfterBlocksearch", {}, (W, 0x2201, 0x19, b"")),
    ("ItpIsEStop", {"nGrpId": GROUP}, (R, 0x310B, 0x11, 2)),
    ("CfgReadExt3DAxisIds", {"nGroupId": GROUP}, (R, 0x310B, 0x552, 32)),
    ("CfgReconfigGroup", {"nGroupId": GROUP}, (W, 0x320B, 0x53, b"")),
    ("CfgReconfigAxis", {"nAxisId": 2}, (W, 0x3202, 0x51, _words(2, 0))),
    (
        *("CfgAddAxisToGroup", {"nGroupId": GROUP, "nAxisId": 5, "nIndex": 3}),
        (W, 0x320B, 0x51, _words(5, 3)),
    ),
    (
        "CfgBuild3DGroup",
        {"nGroupId": GROUP, "nXAxisId": 1, "nYAxisId": 2, "nZAxisId": 3},
        (W, 0x320B, 0x50, _words(1, 2, 3)),
    ),
    (
        "CfgBuildExt3DGroup",
        {"nGroupId": GROUP}
        | {f"n{name}AxisId": n for n, name in enumerate(("X", "Y", "Z", "Q1", "Q2"), 1)},
        (W, 0x320B, 0x52, _words(1, 2, 3, 4, 5, 0, 0, 0)),
    ),
    ("FiFoSetChannelOverride", {"iChannelId": 4, "iOverride": 5}, (W, 0x2304, 0x02, u32(5))),
)


def test_an_edge_is_one_request(nci: NciBench) -> None:
    for new, old, inputs, request in BOTH:
        nci.fire(new, **inputs)
        assert nci.requests() == [request], new
        own = {"nGrpId": GROUP} if request[1] == 0x320B else {"nChnId": CHANNEL}
        nci.fire(old, **inputs, **own)
        assert nci.requests() == [request], old
    for name, inputs, request in ONE:
        nci.fire(name, **inputs)
        assert nci.requests() == [request], name


@pytest.mark.parametrize("own", [{}, {"nChnId": CHANNEL}])
def test_r_parameters_are_one_request(nci: NciBench, own: dict[str, int]) -> None:
    end = "" if own else "Ex"
    numbers = nci.main["numbers"]
    for n in range(1000):
        numbers[n] = n + 0.5
    assert nci.fire(f"ItpWriteRParams{end}", nIndex=0, nCount=1000, **own) == 0
    assert nci.requests() == [
        (W, 0x2301, 0x1000_0000, struct.pack("<1000d", *(n + 0.5 for n in range(1000))))
    ]
    assert [nci.channel.data.registers[n] for n in (0, 899, 900, 999)] == [0.5, 899.5, 900.5, 999.5]
    assert nci.fire(f"ItpReadRParams{end}", nIndex=898, nCount=4, **own) == 0
    assert nci.requests() == [(R, 0x2301, 0x1000_0000 + 898, 32)]
    assert list(numbers)[:5] == [898.5, 899.5, 900.5, 901.5, 4.5]
    for first, count in ((-1, 1), (0, 0), (1, 1000), (999, 2), (1000, 1), (5, -1)):
        for name in ("ItpReadRParams", "ItpWriteRParams"):
            refused = nci.fire(name + end, nIndex=first, nCount=count, **own)
            assert refused == NcError.PLC_R_PARAMETER
            assert nci.requests() == []


STARTS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("ItpStartStopEx", {}),
    ("ItpStartStop", {"nChnId": CHANNEL}),
)


@pytest.mark.parametrize(("name", "own"), STARTS)
def test_start_and_stop(nci: NciBench, name: str, own: dict[str, Any]) -> None:
    """Stop counts where both rise in one call; the start is forgotten."""
    nci.fire(name, "bStart", **own)
    assert nci.requests() == [(W, 0x2201, 0x02, b"")]
    nci.fire(name, "bStop", **own)
    assert nci.requests() == [(W, 0x2201, 0x11, b"")]
    block = nci.main[f"a{name}"]
    block["bStart"] = block["bStop"] = True
    nci.requested_frames.clear()
    nci.call(4)
    assert nci.requests() == [(W, 0x2201, 0x11, b"")]


def test_single_blocks(nci: NciBench) -> None:
    for mode in (0, 1, 0x4000):
        assert nci.fire("ItpSingleBlock", "bExecuteModeChange", nMode=mode) == 0
        assert nci.requests() == [(W, 0x2201, 0x05, u16(mode))]
        assert nci.channel.operation_mode == mode
    nci.fire("ItpSingleBlock", "bTriggerNext")
    assert nci.requests() == [(W, 0x2201, 0x02, b"")]


EDGES = {"ItpStartStop": "bStart", "ItpStartStopEx": "bStart", "ItpSingleBlock": "bTriggerNext"}

UNASKED = {
    "ItpConfirmHsk": NcError.PLC_NO_M_FUNCTION,
}
"""Blocks that ask for nothing where nothing waits, and what they answer."""

GIVEN: dict[str, dict[str, Any]] = {
    "ItpBlocksearch": {"eBlockSearchMode": 1, "nPrgLength": 1, "sPrgName": "a"},
    "FiFoGroupIntegrate": {"iGroupPosition": 1},
    **{key: {"iColDim": 2, "iRowsToWrite": 1} for key in ("FiFoWrite", "FiFoOverwrite")},
    **{f"Itp{verb}RParams{end}": {"nCount": 1} for verb in ("Read", "Write") for end in ("", "Ex")},
    **{key: {"nDNo": 1} for key in ("ItpReadToolDesc", "ItpReadToolDescEx")},
    **{key: {"nDNo": 1} for key in ("ItpWriteToolDesc", "ItpWriteToolDescEx")},
    **{key: {"nZsNo": 54} for key in ("ItpReadZeroShift", "ItpReadZeroShiftEx")},
    **{key: {"nZsNo": 54} for key in ("ItpWriteZeroShift", "ItpWriteZeroShiftEx")},
}


def test_without_a_link_or_an_id_nothing_is_sent(nci: NciBench) -> None:
    """0x4B15, at once."""
    nci.main["bLinked"] = False
    for name in (each for each in blocks() if not each.startswith("ItpPpg")):
        number = nci.fire(name, EDGES.get(name, "bExecute"), **GIVEN.get(name, {}))
        assert number == UNASKED.get(name, NcError.PLC_CHANNEL_NOT_READY), name
        assert nci.requests() == [], name


def test_no_answer_is_0x745_after_the_time_out(nci: NciBench) -> None:
    nci.station.router.deliver = lambda frame: True  # type: ignore[method-assign]
    for name in blocks():
        if name in UNASKED:
            continue
        block = nci.main[f"a{name}"]
        edge = EDGES.get(name, "bExecute")
        timeout = "tTimeout" if name.startswith("FiFo") else "tTimeOut"
        own = {"nChnId": CHANNEL, "nGrpId": GROUP, "nGroupId": GROUP, "nAxisId": 1, "iChannelId": 4}
        for key, value in {**own, **GIVEN.get(name, {})}.items():
            if key in inputs_of(name):
                block[key] = value
        block[timeout] = timedelta(milliseconds=30)
        block[edge] = True
        nci.call()
        assert nci.shown(name) == (True, False, 0), name
        nci.call(5)
        assert nci.shown(name) == (False, True, ReturnCode.CLIENT_TIMEOUT.number), name


def test_edges_while_busy_are_lost_and_errors_stay(nci: NciBench) -> None:
    block = nci.main["aItpLoadProgEx"]
    block["sPrg"], block["nLength"], block["bExecute"] = "none.nc", 7, True
    nci.requested_frames.clear()
    seen = []
    for _ in range(3):
        nci.call()
        seen.append(nci.shown("ItpLoadProgEx"))
    refused = (False, True, NcError.PROGRAM_OPEN.number)
    assert seen == [(True, False, 0), refused, refused]
    block["bExecute"] = False
    nci.call(3)
    assert nci.shown("ItpLoadProgEx") == refused
    block["bExecute"] = True
    nci.call()
    assert nci.shown("ItpLoadProgEx") == (True, False, 0)
    assert len(nci.requests()) == 2
