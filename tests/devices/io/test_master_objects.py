"""The dictionary of the master: records as clients read them."""

import struct
from typing import Any

from achse.codes import AlState, ReturnCode

MASTER = 0xFFFF
SDO = 0xF302


def test_a_configured_slave_by_complete_access(io: Any) -> None:
    data = io.read(MASTER, SDO, 0x8000_0100 + 0x10000, 80)
    assert len(data) == 80
    entries, station, kind, name = struct.unpack_from("<HH16s32s", data)
    assert (entries, station) == (36, 1002)
    assert kind.rstrip(b"\0") == b"loopback"
    assert name.rstrip(b"\0") == b"Box 2"
    assert struct.unpack_from("<5I2H", data, 52)[2:] == (0x100B, 1, 0, 256, 256)


def test_single_fields(io: Any) -> None:
    assert io.read(MASTER, SDO, 0x8001_0003, 32).rstrip(b"\0") == b"Box 2"
    assert len(io.read(MASTER, SDO, 0x8001_0002, 16)) == 16
    assert io.read(MASTER, SDO, 0x8000_0021) == (256).to_bytes(2, "little")
    assert io.read(MASTER, SDO, 0xF020_0000, 2) == b"\x03\0"
    assert io.read(MASTER, SDO, 0xF020_0002) == (1002).to_bytes(2, "little")
    assert io.code(lambda: io.read(MASTER, SDO, 0x8003_0001)) == ReturnCode.INVALID_OFFSET.number
    assert io.code(lambda: io.read(MASTER, SDO, 0x1018_0009)) == ReturnCode.INVALID_OFFSET.number


def test_what_was_found(io: Any) -> None:
    io.up(AlState.PREOP)
    record = io.read(MASTER, SDO, 0x9001_0100, 22)
    count, station, vendor, product, revision, serial, links = struct.unpack("<HH4IH", record)
    assert (count, station, product, serial) == (6, 1002, 0x100B, 0)
    assert (vendor, revision) == (0, 1)
    assert links & 0x0A00 == 0x0A00
    assert io.read(MASTER, SDO, 0xF040_0000, 2) == b"\x03\0"


def test_a_scan(io: Any) -> None:
    io.up(AlState.PREOP)
    assert io.read(MASTER, SDO, 0xF002_0002) == b"\0"
    io.write(MASTER, SDO, 0xF002_0001, b"\1\0")
    assert io.read(MASTER, SDO, 0xF002_0002) == b"\1"
    assert io.read(MASTER, SDO, 0xF002_0003) == b"\x01\0\x03\0\0\0"


def test_diagnosis_and_its_reset(io: Any) -> None:
    io.up()
    io.segment.break_link(io.segment.slaves[2])
    io.run(300)
    losses = 0xA002_000A
    assert io.read(MASTER, SDO, losses) == b"\1\0\0\0"
    io.write(MASTER, SDO, 0xF200_0010, b"\1\0")
    assert io.read(MASTER, SDO, losses) == bytes(4)
    assert io.read(MASTER, SDO, 0xF120_0010) == b"\0\0"  # one does not answer
    assert int.from_bytes(io.read(MASTER, SDO, 0xF120_0003), "little") > 500
    code = io.code(lambda: io.write(MASTER, SDO, 0x8000_0001, b"\1\0"))
    assert code == ReturnCode.INVALID_ACCESS.number
