"""A ring between two adapters: who processes which frame, and where it comes out."""

from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Slave
from achse.ethercat.registers import Register
from achse.ethercat.ring_segment import RingSegment

COUNT = EthercatFrame([Datagram.at(DatagramCommand.BRD, 0, Register.TYPE, b"\0")]).encode()


def passed(segment: RingSegment, adapter: int) -> tuple[int, int] | None:
    """How many slaves a frame of that adapter passes, and where it comes out."""
    came = segment.process_from(adapter, COUNT)
    if came is None:
        return None
    return EthercatFrame.decode(came[0]).datagrams[0].counter, came[1]


def test_a_closed_ring_processes_one_way_only() -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(4))
    assert (passed(ring, 0), passed(ring, 1), ring.parts) == ((4, 1), (0, 0), (4, 0))


@given(count=st.integers(1, 6), cuts=st.sets(st.integers(0, 6)), end=st.booleans())
def test_each_adapter_reaches_its_part(count: int, cuts: set[int], end: bool) -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(count))
    inside = sorted(cut for cut in cuts if cut < count)
    for cut in inside:
        ring.break_link(ring.slaves[cut])
    ring.cut_end(not end)
    if not inside:
        assert passed(ring, 0) == (count, int(end))
        assert passed(ring, 1) == ((0, 0) if end else None)
    else:
        assert passed(ring, 0) == ((inside[0], 0) if inside[0] else None)
        assert passed(ring, 1) == ((count - inside[-1], 1) if end else None)
    for cut in inside:
        ring.repair_link(ring.slaves[cut])
    ring.cut_end(False)
    assert passed(ring, 0) == (count, 1)


def test_both_parts_are_addressed_by_station() -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(3))
    for number, slave in enumerate(ring.slaves):
        slave.esc.write(Register.STATION_ADDRESS, bytes((number, 4)))
    ring.break_link(ring.slaves[2])
    ask = EthercatFrame(
        [Datagram.at(DatagramCommand.FPRD, 0x402, Register.STATION_ADDRESS, b"\0\0")]
    ).encode()
    near, far = (ring.process_from(adapter, ask) for adapter in (0, 1))
    assert near is not None
    assert far is not None
    assert EthercatFrame.decode(near[0]).datagrams[0].counter == 0
    assert EthercatFrame.decode(far[0]).datagrams[0].data == b"\x02\x04"


def test_the_last_slave_can_turn_frames_round() -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(2))
    ring.slaves[1].esc.write(Register.DL_CONTROL + 1, b"\x0c")
    assert (passed(ring, 0), passed(ring, 1)) == ((2, 0), None)
    ring.slaves[1].esc.write(Register.DL_CONTROL + 1, b"\0")
    assert passed(ring, 0) == (2, 1)
