"""What each trigger of a TcNC block sends, byte by byte: one request to port 500 per command.

Services and layouts: 002 §6.4.4.3 in the form of TwinCAT 3.
"""

import struct
from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.codes import NcError


def _numbers(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


def _words(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


SENT: tuple[tuple[str, str, dict[str, Any], int, bytes], ...] = (
    ("AXFNC", "RESET", {}, 0x01, b""),
    ("AXFNC", "CALIBR", {}, 0x10, b""),
    ("AXFNC", "SETPOS", {"MODE": 2, "VAL": -3.5}, 0x1A, _words(2, 0) + _numbers(-3.5)),
    ("AXFNC", "SETTARG", {"MODE": 5, "VAL": 370.0}, 0x11, _words(5, 0) + _numbers(370.0)),
    ("AXFNC", "SETDRIVE", {"MODE": 1, "VAL": 5.0}, 0x26, _words(1, 0) + _numbers(5.0)),
    ("AXFNC", "MANFW", {"MODE": 9, "VAL": 20.0}, 0x20, _words(3, 0) + _numbers(0.0, 20.0)),
    ("AXFNC", "MANBW", {"MODE": 9, "VAL": 20.0}, 0x20, _words(4, 0) + _numbers(0.0, 20.0)),
    (
        "AXACT", "START", {"MODE": 1, "TARGPOS": 50.0, "VELOCITY": 30.0},
        0x20, _words(1, 0) + _numbers(50.0, 30.0),
    ),
    ("AXACT", "STOP", {}, 0x02, b""),
    (
        "AXACTEX", "START",
        {"MODE": 1, "TARGPOS": 10.0, "VELOCITY": 20.0, "ACCEL": 300.0, "DECEL": -1.0, "JERK": 0.0},
        0x21, _words(1, 0) + _numbers(10.0, 20.0)
        + _words(0, 0) + _numbers(300.0) + _words(1, 0) + _numbers(0.0)
        + _words(0, 0) + _numbers(0.0),
    ),
    ("AXACTEX", "STOP", {}, 0x02, b""),
    (
        "AXCPL", "CPLON",
        {"MASTERID": 2, "CPLMODE": 16, "CPLPAR1": 1.0, "CPLPAR2": 2.0, "CPLPAR3": 3.0,
         "CPLPAR4": 4.0},
        0x40, _words(16, 2, 0, 0) + _numbers(1.0, 2.0, 3.0, 4.0),
    ),
    ("AXCPL", "CPLOFF", {}, 0x41, b""),
    (
        "AXCPLTAB", "CPLON",
        {"MASTERID": 2, "SLAVEOFFSET": 1.5, "MASTEROFFSET": -2.5, "SLAVEABSOLUT": 1, "TABID": 7},
        0x45, _words(10, 2, 0, 0) + _numbers(1.5, -2.5) + _words(1, 0, 7) + bytes(36),
    ),
    ("AXCPLTAB", "CPLOFF", {}, 0x41, b""),
    (
        "AXSCOM", "COMP_ON",
        {"MODE": 1, "ACCP": 1.0, "ACCM": 2.0, "VDELTA": 3.0, "VPROC": 4.0, "COMPVAL": 5.0,
         "COMPDIST": 6.0},
        0x30, _words(1, 0) + _numbers(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
    ),
    ("AXSCOM", "COMP_OFF", {}, 0x31, b""),
)  # fmt: skip


@pytest.mark.parametrize(("block", "edge", "inputs", "offset", "data"), SENT)
def test_one_request_per_command(
    bench: Any, block: str, edge: str, inputs: dict[str, Any], offset: int, data: bytes
) -> None:
    on = bench(b=block)
    on.set("b", AXID=1, **inputs, **{edge: True})
    on.call(5)
    assert on.requests() == [(500, 0x4201, offset, data)]
    on.set("b", **dict.fromkeys(inputs, 0), **{edge: False})
    on.call(3)
    falling = {"SETDRIVE": 0x27, "MANFW": 0x02, "MANBW": 0x02}.get(edge)
    assert on.requests() == ([] if falling is None else [(500, 0x4201, falling, b"")])


def test_a_new_target_and_velocity(bench: Any) -> None:
    on = bench(n="FB_AxisNewTargPosAndVelo")
    on.set(
        "n", iAxisId=1, eCmdType=11, eTargPosType=1, fTargPos=5.0, fVelo=6.0, fSwitchPos=7.0,
        bExecute=True,
    )  # fmt: skip
    on.call()
    block = on.main["n"]
    assert (block["bBusy"], block["bErr"], block["iErrId"]) == (True, False, 0)
    on.call()
    assert on.requests() == [(500, 0x4201, 0x12, _words(11, 1) + _numbers(5.0, 6.0, 7.0))]
    assert (block["bBusy"], block["bErr"]) == (False, True)  # the axis stands
    assert block["iErrId"] == NcError.of(block["iErrId"])


def test_a_gear_ratio_changes_while_coupled(bench: Any) -> None:
    """A second CPLON of a linear coupling to the same master is 0x42; after an error 0x40."""
    on = bench(c="AXCPL")

    def couple(**inputs: Any) -> list[int]:
        on.set("c", CPLON=True, **inputs)
        on.call(3)
        on.set("c", CPLON=False)
        on.call()
        return [offset for _, _, offset, _ in on.requests()]

    assert couple(AXID=2, MASTERID=1, CPLMODE=1, CPLPAR1=2.0) == [0x40]
    assert on.axis(2).coupling.parameters[0] == 2.0
    assert couple(CPLPAR1=2.5) == [0x42]
    assert on.shown("c") == (False, False, 0)
    assert on.axis(2).coupling.parameters[0] == 2.5
    assert couple(MASTERID=3) == [0x40]  # another master: refused as any second coupling
    assert on.shown("c")[1]
    on.set("c", CPLOFF=True, MASTERID=1)
    on.call(3)
    assert on.shown("c") == (False, False, 0)
    on.set("c", CPLOFF=False)
    on.requests()
    assert couple() == [0x40]
    assert on.axis(2).coupling.law == 1


def test_another_client_uncoupled_the_slave(bench: Any) -> None:
    from achse.motion import commands

    on = bench(c="AXCPL")
    for offset in (0x40, 0x42, 0x40):
        on.set("c", AXID=2, MASTERID=1, CPLMODE=1, CPLPAR1=2.0, CPLON=True)
        on.call(3)
        assert [each[2] for each in on.requests()] == [offset]
        on.set("c", CPLON=False)
        on.call()
        if offset == 0x40 and on.axis(2).coupling.law:
            assert commands.decouple(on.axis(2)) == 0
    assert not on.shown("c")[1]


def test_a_compensation_that_is_cut_short_is_a_warning(bench: Any) -> None:
    on = bench(s="AXSCOM", a="AXACT")
    on.set("a", AXID=1, MODE=1, TARGPOS=500.0, VELOCITY=50.0, START=True)
    on.call(50)
    on.set(
        "s", AXID=1, MODE=1, ACCP=100.0, ACCM=100.0, VDELTA=5.0, VPROC=50.0, COMPVAL=50.0,
        COMPDIST=60.0, COMP_ON=True,
    )  # fmt: skip
    on.call(4)
    assert on.shown("s") == (False, True, NcError.COMPENSATION_IN_PART)
    assert on.main["fromNc1"]["nStateDWord"] >> 13 & 1


def test_the_address_of_the_hardware(bench: Any) -> None:
    on = bench(g="FB_GetAxisAmsAddr")
    on.set("g", iAxisId=1, bExecute=True)
    on.call()
    block = on.main["g"]
    assert block["bBusy"]
    on.call()
    assert (block["bBusy"], block["bError"], block["iErrId"]) == (False, False, 0)
    (frame,) = on.requested_frames
    assert (AmsAddress(frame.target).port, frame.data) == (500, _words(0x4001, 0x31, 10))
    assert len(block["AxisNetId"].split(".")) == 6
    assert block["AxisNetId"] == ".".join(map(str, block["AxisNetIdBytes"]))
    on.set("g", bExecute=False)
    on.call()
    on.set("g", iAxisId=200, bExecute=True)
    on.call(2)
    assert (block["bError"], block["iErrId"]) == (True, NcError.AXIS_ID)
    on.set("g", bExecute=False)
    on.call()
    on.set("g", iAxisId=1, sNetId="9.9.9.9.9.9", bExecute=True)
    on.call(3)
    assert (block["bError"], block["iErrId"]) == (True, 7)
