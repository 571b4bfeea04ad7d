"""Slaves by ADS: objects as SDO gives them, refusals with their abort codes, sums, descriptions."""

import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, ReturnCode, SdoAbort
from achse.ethercat.mailbox import MailboxProtocol
from tests.devices.io.conftest import IoBus
from tests.ethercat.master.messaging import Messenger

DRIVE, BOX = 1001, 1002
VENDOR = 0xF430
TX_PDO, RX_PDO = 0xF3F8, 0xF3F9
SDO, ERROR, SUM_READ, SUM_WRITE = 0xF302, 0xF303, 0xF304, 0xF305


def value_of(drive: Any, index: int, subindex: int) -> tuple[bytes | None, int]:
    """The value, or the abort code it is refused with."""
    try:
        return drive.read_object(index, subindex), 0
    except SdoAbort as abort:
        return None, abort.code.number


def test_all_entries_of_the_drive_are_what_sdo_gives(io: Any) -> None:
    io.ring.rounds = 20
    io.up(AlState.PREOP)
    for described in io.drive.objects():
        for entry in described.entries:
            offset = described.index << 16 | entry.subindex
            expected, number = value_of(io.drive, described.index, entry.subindex)
            if expected is None:
                assert io.code(lambda offset=offset: io.read(DRIVE, SDO, offset))
                assert io.read(DRIVE, ERROR, 0)[8:12] == number.to_bytes(4, "little")
            else:
                assert io.read(DRIVE, SDO, offset) == expected


def test_writes_of_any_length(io: Any) -> None:
    io.up(AlState.PREOP)
    for size in (1, 4, 5, 300, 1000):
        io.write(BOX, SDO, 0x2000_0000, bytes(range(256))[:4] * (size // 4 + 1))
        assert len(io.read(BOX, SDO, 0x2000_0000, 2000)) == size // 4 * 4 + 4


def test_complete_access_is_bit_8(io: Any) -> None:
    io.up(AlState.PREOP)
    whole = io.read(BOX, SDO, 0x1018_0100)
    assert (len(whole), whole[:2]) == (18, b"\4\0")
    assert io.read(BOX, SDO, 0x1018_0101) == whole[2:]
    assert io.read(BOX, SDO, 0x1018_0301) == whole[2:]  # bit 9: ten times the time


@pytest.mark.parametrize(
    ("offset", "data", "code", "abort"),
    [
        (0x5FFF_0000, None, ReturnCode.INVALID_OFFSET, AbortCode.NO_OBJECT),
        (0x1018_0009, None, ReturnCode.INVALID_OFFSET, AbortCode.NO_SUBINDEX),
        (0x1000_0000, b"\0\0\0\0", ReturnCode.INVALID_ACCESS, AbortCode.READ_ONLY),
        (0x7000_0001, b"\0\0", ReturnCode.SYNTAX, AbortCode.LENGTH),
    ],
)
def test_aborts_and_the_last_error(
    io: Any, offset: int, data: bytes | None, code: ReturnCode, abort: AbortCode
) -> None:
    io.up(AlState.PREOP)
    assert io.read(BOX, ERROR, 0)[8:12] == bytes(4)
    if data is None:
        refused = io.code(lambda: io.read(BOX, SDO, offset))
    else:
        refused = io.code(lambda: io.write(BOX, SDO, offset, data))
    assert refused == code.number
    message = io.read(BOX, ERROR, 0)
    assert message[:8] == io.client
    assert int.from_bytes(message[8:12], "little") == abort.number
    assert abort.text.encode() in message


def test_longer_than_requested_is_refused(io: Any) -> None:
    io.up(AlState.PREOP)
    assert io.code(lambda: io.read(BOX, SDO, 0x1000_0000, 3)) == ReturnCode.INVALID_SIZE.number
    assert len(io.read(BOX, SDO, 0x1000_0000, 100)) == 4


def test_without_mailbox_state_it_is_refused_at_once(io: Any) -> None:
    io.run(60)
    assert io.code(lambda: io.read(BOX, SDO, 0x1000_0000)) == ReturnCode.INVALID_STATE.number


def test_many_in_one(io: Any) -> None:
    io.up(AlState.PREOP)
    wanted = [(0x1000_0000, 4), (0x5FFF_0000, 4), (0x1018_0002, 4), (0x2000_0000, 2)]
    request = b"".join(struct.pack("<III", SDO, *each) for each in wanted)
    answer = io.read_write(BOX, SUM_READ, len(wanted), 1000, request)
    heads = struct.unpack("<8I", answer[:32])
    offset, size = ReturnCode.INVALID_OFFSET.number, ReturnCode.INVALID_SIZE.number
    assert heads == (0, 4, offset, 0, 0, 4, size, 0)
    assert answer[32:] == (0xC0DE_0001).to_bytes(4, "little") + (0x100B).to_bytes(4, "little")
    parts = [(0x2000_0000, b"text"), (0x1000_0000, b"\0\0\0\0")]
    request = b"".join(struct.pack("<III", SDO, each, len(data)) for each, data in parts)
    answer = io.read_write(BOX, SUM_WRITE, 2, 100, request + b"".join(data for _, data in parts))
    assert struct.unpack("<2I", answer) == (0, ReturnCode.INVALID_ACCESS.number)
    assert io.line[0].text == b"text"


@pytest.mark.parametrize(
    ("count", "request_data", "code"),
    [
        (0, b"", ReturnCode.INVALID_OFFSET),
        (501, bytes(501 * 12), ReturnCode.INVALID_OFFSET),
        (2, bytes(12), ReturnCode.INVALID_SIZE),
        (1, bytes(12), ReturnCode.INVALID_GROUP),
        (1, struct.pack("<III", SDO, 0, 0x7FFF_FFFF), ReturnCode.INVALID_SIZE),
    ],
)
def test_broken_sums_are_refused(
    io: Any, count: int, request_data: bytes, code: ReturnCode
) -> None:
    io.up(AlState.PREOP)
    for group in (SUM_READ, SUM_WRITE):
        assert io.code(lambda group=group: io.read_write(BOX, group, count, 9, request_data)) == (
            code.number
        )


def test_descriptions(io: Any) -> None:
    io.up(AlState.PREOP)
    indices = io.read(BOX, 0xF3FC, 1 << 16, 4096)
    numbers = struct.unpack(f"<{len(indices) // 2}H", indices)
    assert numbers == (1, *(each.index for each in io.line[0].objects()))
    described = io.read(BOX, 0xF3FD, 0x1018 << 16)
    assert described[6:] == b"Identity"
    assert struct.unpack_from("<HHBB", described)[2:] == (4, 9)
    entry = io.read(BOX, 0xF3FE, 0x1018_0001)
    assert struct.unpack_from("<HBB", entry) == (0x1018, 1, 0)
    assert io.code(lambda: io.read(BOX, 0xF3FD, 0x5FFF << 16)) == ReturnCode.INVALID_OFFSET.number
    assert io.code(lambda: io.read(BOX, 0xF3FD, 0x1018 << 16, 3)) == ReturnCode.INVALID_SIZE.number


@pytest.mark.parametrize("group", [0xF3FB])
def test_what_is_not_served_says_so(io: Any, group: int) -> None:
    io.up(AlState.PREOP)
    unsupported = ReturnCode.SERVICE_NOT_SUPPORTED.number
    assert io.code(lambda: io.read(BOX, group, 0)) == unsupported
    assert io.code(lambda: io.write(BOX, group, 0)) == unsupported
    assert io.code(lambda: io.read_write(BOX, group, 0, 4, b"")) == unsupported


def test_parameters_of_a_sercos_drive(io: Any) -> None:
    """Answered by a service that the first slave has for this test."""
    io.up(AlState.PREOP)
    remaining = {32: b"\x03\x00"}

    def answer(data: bytes) -> list[bytes]:
        idn = int.from_bytes(data[2:4], "little")
        if data[0] & 7 == 3:
            remaining[idn] = data[4:]
            return [bytes((data[0] & 0xE0 | 4, data[1])) + data[2:4]]
        if idn not in remaining:
            return [bytes((data[0] & 0xE0 | 0x12, data[1])) + data[2:4] + b"\x01\x10"]
        return [bytes((data[0] & 0xE0 | 2, data[1])) + data[2:4] + remaining[idn]]

    io.segment.slaves[1]._mailbox._services[MailboxProtocol.SOE] = answer
    assert io.read(BOX, 0xF420, 0x0140_0020) == b"\x03\x00"
    io.write(BOX, 0xF420, 0x0040_0021, b"\x07\x00")
    assert io.read(BOX, 0xF420, 0x0040_0021) == b"\x07\x00"
    assert io.code(lambda: io.read(BOX, 0xF420, 0x0040_0099)) == 0x700
    assert io.read(BOX, 0xF421, 0)[8:12] == b"\x01\x10\0\0"
    assert io.code(lambda: io.read(1001, 0xF420, 0x0040_0020)) == 0x701  # speaks no SoE


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.binary(max_size=244), st.binary(max_size=200))
def test_messages_of_a_vendor(vendor: int, data: bytes, news: bytes) -> None:
    io = IoBus(1, Messenger).up(AlState.PREOP)
    device: Any = io.line[0]
    head = vendor.to_bytes(4, "little")
    assert io.read(BOX, VENDOR, 0) == bytes(10)
    answer = io.read_write(BOX, VENDOR, 0, 300, head + b"\x07\0" + data)
    assert answer == head + b"\x08\0" + data[::-1]
    io.write(BOX, VENDOR, 0, head + b"\x01\0" + data)
    assert device.messages[-1] == head + b"\x01\0" + data
    device.outbox.append((15, head + b"\x09\0" + news))
    io.run(200)
    assert io.read(BOX, VENDOR, 0) == b"\x01\0\0\0" + head + b"\x09\0" + news


def test_refusals_of_messages_of_a_vendor() -> None:
    io = IoBus(1, Messenger)
    assert io.code(lambda: io.write(BOX, VENDOR, 0, bytes(6))) == 0x712  # not in PreOp
    io.up(AlState.PREOP)
    assert io.code(lambda: io.write(BOX, VENDOR, 0, bytes(5))) == 0x705


@pytest.mark.parametrize("state", [AlState.INIT, AlState.PREOP, AlState.OP])
def test_slave_without_voe_refuses_each_message_of_a_vendor(io: Any, state: AlState) -> None:
    io.up(state)
    codes = [
        io.code(lambda: io.read(BOX, VENDOR, 0)),
        io.code(lambda: io.write(BOX, VENDOR, 0, bytes(6))),
        io.code(lambda: io.read_write(BOX, VENDOR, 0, 100, bytes(6))),
    ]
    assert codes == [0x701] * 3


@pytest.mark.parametrize("base", [0, 0x1A00])
def test_pdos_by_mailbox(io: Any, base: int) -> None:
    assert io.code(lambda: io.read(BOX, TX_PDO, base)) == 0x712  # not in PreOp
    io.up(AlState.PREOP)
    assert io.read(DRIVE, TX_PDO, base) == io.drive.read_inputs()
    rx_base = base and 0x1600
    io.write(BOX, RX_PDO, rx_base, b"\x01\x02\x03\x04")
    assert io.read(BOX, RX_PDO, rx_base) == b"\x01\x02\x03\x04"
    assert io.code(lambda: io.read(BOX, TX_PDO, base, 3)) == 0x705
    assert io.code(lambda: io.read(BOX, TX_PDO, base + 5)) == 0x701
    assert io.code(lambda: io.read(BOX, TX_PDO, base + 512)) == 0x703
    assert io.code(lambda: io.write(BOX, TX_PDO, base, b"")) == 0x704
