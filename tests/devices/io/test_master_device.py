"""Port 65535 of a bus: states, addresses, counters, datagrams."""

import struct
from typing import Any

import pytest

from achse.codes import AlState, AlStatus, ReturnCode

MASTER = 0xFFFF


def words(data: bytes) -> tuple[int, ...]:
    return struct.unpack(f"<{len(data) // 2}H", data)


def longs(data: bytes) -> tuple[int, ...]:
    return struct.unpack(f"<{len(data) // 4}I", data)


def test_states_of_master_and_slaves(io: Any) -> None:
    assert io.read(MASTER, 3, 0x100, 2) == b"\1\0"
    io.write(MASTER, 3, AlState.SAFEOP)
    io.run(300)
    assert io.read(MASTER, 3, 0x100, 2) == b"\4\0"
    assert io.read(MASTER, 9, 0) == b"\4\0" * 3
    io.write(MASTER, 9, 1002, b"\x08\0")
    io.run(100)
    assert io.read(MASTER, 9, 1002) == b"\x08\0"
    assert io.read(MASTER, 9, 1001) == b"\x04\0"


@pytest.mark.parametrize(
    ("ask", "code"),
    [
        (lambda io: io.read(MASTER, 3, 0), ReturnCode.INVALID_OFFSET),
        (lambda io: io.write(MASTER, 3, 3), ReturnCode.INVALID_DATA),
        (lambda io: io.read(MASTER, 9, 7), ReturnCode.INVALID_OFFSET),
        (lambda io: io.write(MASTER, 9, 1001, b"\5\0"), ReturnCode.INVALID_DATA),
        (lambda io: io.write(MASTER, 9, 1001, b"\4"), ReturnCode.INVALID_SIZE),
        (lambda io: io.write(MASTER, 9, 1001, b"\4\4"), ReturnCode.INVALID_DATA),
        (lambda io: io.read(MASTER, 0x11, 5), ReturnCode.INVALID_OFFSET),
        (lambda io: io.write(MASTER, 7, 0, b""), ReturnCode.INVALID_ACCESS),
        (lambda io: io.read(MASTER, 0x2F, 0), ReturnCode.INVALID_STATE),
        (lambda io: io.write(MASTER, 0x2F, 3), ReturnCode.INVALID_OFFSET),
        (lambda io: io.read(MASTER, 0x99, 0), ReturnCode.INVALID_GROUP),
    ],
)
def test_what_cannot_be_is_refused(io: Any, ask: Any, code: ReturnCode) -> None:
    assert io.code(lambda: ask(io)) == code.number


def test_an_error_is_acknowledged_by_the_request(io: Any) -> None:
    io.up(AlState.PREOP)
    io.line[0].refuse = AlStatus.INPUT_MAPPING
    io.master.request(AlState.SAFEOP)
    io.run(300)
    assert io.read(MASTER, 9, 1002)[0] == 0x12
    io.write(MASTER, 9, 1002, b"\x14\0")
    io.run(100)
    assert io.read(MASTER, 9, 1002)[0] == 4


def test_lists(io: Any) -> None:
    assert io.read(MASTER, 6, 0, 2) == b"\3\0"
    assert io.read(MASTER, 6, 0, 4) == b"\3\0\0\0"
    assert words(io.read(MASTER, 7, 0)) == (1001, 1002, 1003)
    io.up(AlState.PREOP)
    assert longs(io.read(MASTER, 0x11, 1003)) == (0, 0x100B, 1, 1)
    assert len(io.read(MASTER, 0x22, 0, 4096)) == 192
    assert io.read(MASTER, 0x48, 0) == b"\1\0\0\0"
    assert longs(io.read(MASTER, 0x12, 0)) == (0, 0, 0)
    assert longs(io.read(MASTER, 0x12, 1001)) == (0, 0, 0, 0)
    assert longs(io.read(MASTER, 0x13, 0)) == (0, 0, 0)
    assert longs(io.read(MASTER, 0x14, 0)) == (0, 0, 0)
    assert words(io.read(MASTER, 0x45, 0)) == (0x200,)


def test_clocks_and_why_a_slave_does_not_reach_its_state(io: Any) -> None:
    io.up()
    io.master.slaves[1].clock_difference_ns = -70
    assert struct.unpack("<3i", io.read(MASTER, 0x103, 0)) == (0, -70, 0)
    assert io.read(MASTER, 0x104, 1001) == b"\0"
    io.master.slaves[0].last_trouble = "it drifts"
    assert io.read(MASTER, 0x104, 1001) == b"it drifts\0"
    assert io.code(lambda: io.read(MASTER, 0x104, 1099)) == 0x703


def test_frame_statistics_and_their_reset(io: Any) -> None:
    io.up()
    time, sent, lost, acyclic, acyclic_lost = longs(io.read(MASTER, 0x0C, 0))
    assert time == io.master.now_ns // 1_000_000
    assert sent > 10
    assert acyclic > 10
    assert (lost, acyclic_lost) == (0, 0)
    io.write(MASTER, 0x0C, 0)
    assert longs(io.read(MASTER, 0x0C, 0))[1:] == (0, 0, 0, 0)


def test_abnormal_changes_and_losses(io: Any) -> None:
    io.up()
    io.line[0].fault = AlStatus.NO_VALID_DATA
    io.run(300)
    io.segment.break_link(io.segment.slaves[2])
    io.run(300)
    assert longs(io.read(MASTER, 0x13, 0)) == (0, 1, 0)
    assert longs(io.read(MASTER, 0x14, 0)) == (0, 0, 1)
    io.write(MASTER, 0x12, 0)
    assert longs(io.read(MASTER, 0x14, 0)) == (0, 0, 0)


def test_the_deviation_of_the_clocks(io: Any) -> None:
    io.write(MASTER, 0x2F, 1)
    io.up()
    io.run(3000)
    figures = longs(io.read(MASTER, 0x2F, 0, 96))
    assert len(figures) == 24
    assert figures[0] == figures[1] + figures[2] == sum(figures[4:]) > 0
    io.write(MASTER, 0x2F, 0)
    assert longs(io.read(MASTER, 0x2F, 0, 96)) == (0,) * 24


@pytest.mark.parametrize("group", [0x2C, 0x500])
def test_slaves_are_counted_by_a_datagram(io: Any, group: int) -> None:
    io.up(AlState.PREOP)
    request = struct.pack("<BBHHHH4sH", 1, 0xFF, 0, 0, 4, 0, bytes(4), 0)
    answer = io.read_write(MASTER, group, 0, len(request), request)
    command, index, adp, _, _, _, data, counter = struct.unpack("<BBHHHH4sH", answer)
    assert (command, index, adp, counter) == (1, 0xFF, 3, 1)
    assert data[0] == 0x11
    io.segment.break_link(io.segment.slaves[0])
    io.run(300)
    code = io.code(lambda: io.read_write(MASTER, group, 0, len(request), request))
    assert code == ReturnCode.DEVICE_TIMEOUT.number


def test_round_trips_and_the_interface(io: Any) -> None:
    """In process there are none; on an interface it is what the bus says."""
    assert io.read(MASTER, 0x101, 0, 48) == bytes(48)
    assert [io.read(MASTER, 0x102, which) for which in (0, 1)] == [b"\0", b"\0"]

    class Trips:
        count, missing, last_ns, largest_ns, mean_ns = 7, 1, 90, 300, 150.4

        def within_ns(self, share: float) -> int:
            return round(share * 200)

        def reset(self) -> None:
            self.count = 0

    class Way:
        interface, second_interface, trouble = "eth1", "eth2", "cable pulled"
        round_trips = Trips()

    served = io.served
    served.way = Way()
    assert struct.unpack("<6Q", io.read(MASTER, 0x101, 0, 48)) == (7, 1, 90, 150, 198, 300)
    reports = [io.read(MASTER, 0x102, which) for which in range(4)]
    assert reports == [b"eth1\0", b"cable pulled\0", b"eth2\0", b"\0"]
    io.write(MASTER, 0x101, 0, b"")
    assert struct.unpack_from("<Q", io.read(MASTER, 0x101, 0, 48)) == (0,)
    assert io.code(lambda: io.read(MASTER, 0x102, 4)) == ReturnCode.INVALID_OFFSET.number
