"""States and lists of a bus."""

import struct
from typing import Any

import pytest

from achse.ams import NetId
from achse.codes import AbortCode, AlState, AlStatus, ReturnCode
from achse.devices.io.served import bus_error, default_net_id
from achse.ethercat.master import SdoRefusal, errors


def test_the_net_id_of_a_bus() -> None:
    assert default_net_id(NetId("5.24.37.144.1.1"), 1) == NetId("5.24.37.144.2.1")
    assert default_net_id(NetId("5.24.37.144.1.1"), 2) == NetId("5.24.37.144.3.1")


def test_state_bytes_of_a_lost_slave_and_the_one_before(io: Any) -> None:
    io.up()
    first, second, third = io.master.slaves
    assert [io.served.state_bytes(each) for each in io.master.slaves] == [b"\x08\0"] * 3
    assert io.served.dev_state == 0
    io.segment.break_link(io.segment.slaves[2])
    io.run(300)
    assert io.served.state_bytes(third) == b"\0\x01"
    assert io.served.state_bytes(second) == b"\x08\x24"
    assert io.served.dev_state == 0x0001
    assert io.served.state_bytes(first) == b"\x08\0"


@pytest.mark.parametrize(
    ("state", "bit"),
    [(AlState.INIT, 0x100), (AlState.PREOP, 0x200), (AlState.SAFEOP, 0x400), (AlState.OP, 0)],
)
def test_the_state_of_the_bus_reports_slaves_below_op(io: Any, state: AlState, bit: int) -> None:
    io.run(100)
    io.up(state)
    assert io.served.dev_state == bit


def test_a_slave_with_an_error(io: Any) -> None:
    io.up(AlState.PREOP)
    io.line[0].refuse = AlStatus.INPUT_MAPPING
    io.master.request(AlState.OP)
    io.run(300)
    assert io.served.dev_state & 0x0800
    assert io.served.state_bytes(io.master.slaves[1])[0] == 0x12


def test_the_topology_record(io: Any) -> None:
    io.up(AlState.PREOP)
    data = io.served.topology()
    assert len(data) == 3 * 64
    station, position, *rest = struct.unpack_from("<HH4H4H4II", data, 64)
    assert (station, position) == (1002, 0xFFFF)
    assert rest[:4] == [1001, 1003, 0, 0]
    assert rest[4:8] == [0, 0xFFFE, 0, 0]
    assert rest[8] == 300
    assert rest[12] & 0x7 == 0x7


@pytest.mark.parametrize(
    ("trouble", "code"),
    [
        (SdoRefusal(1, 2, 3, AbortCode.NO_OBJECT.number), ReturnCode.INVALID_OFFSET),
        (SdoRefusal(1, 2, 3, AbortCode.READ_ONLY.number), ReturnCode.INVALID_ACCESS),
        (SdoRefusal(1, 2, 3, AbortCode.VALUE_RANGE.number), ReturnCode.INVALID_DATA),
        (SdoRefusal(1, 2, 3, AbortCode.DEVICE_STATE.number), ReturnCode.INVALID_STATE),
        (SdoRefusal(1, 2, 3, 0x1234), ReturnCode.SYNTAX),
        (errors.MailboxTimeout("x"), ReturnCode.DEVICE_TIMEOUT),
        (errors.NoMailbox("x"), ReturnCode.SERVICE_NOT_SUPPORTED),
        (errors.SlaveNotReady("x"), ReturnCode.INVALID_STATE),
        (errors.WrongAnswer("x"), ReturnCode.DEVICE_ERROR),
    ],
)
def test_what_goes_wrong_has_its_ads_error(trouble: errors.BusError, code: ReturnCode) -> None:
    assert bus_error(trouble).code == code.number
