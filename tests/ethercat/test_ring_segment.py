"""A ring between two adapters: who processes which frame, and where it comes out."""

import pytest
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


@given(
    count=st.integers(1, 6),
    cuts=st.sets(st.integers(0, 6)),
    adapters=st.tuples(st.booleans(), st.booleans()),
)
def test_each_adapter_reaches_its_part(
    count: int, cuts: set[int], adapters: tuple[bool, bool]
) -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(count))
    for adapter, linked in enumerate(adapters):
        ring.connect(adapter, linked)
    for cut in cuts:
        if cut <= count:
            ring.cut(cut)
    end = adapters[1] and count not in cuts
    inside = sorted({each for each in cuts if each < count} | ({0} if not adapters[0] else set()))
    if not inside:
        assert passed(ring, 0) == (count, int(end))
        assert passed(ring, 1) == ((0, 0) if end else None)
    else:
        assert passed(ring, 0) == ((inside[0], 0) if inside[0] else None)
        assert passed(ring, 1) == ((count - inside[-1], 1) if end else None)
    assert ring.whole == (end and not inside)
    for cut in range(count + 1):
        ring.mend(cut)
    for adapter in (0, 1):
        ring.connect(adapter, True)
    assert passed(ring, 0) == (count, 1)
    assert ring.whole


def test_there_are_as_many_cables_as_slaves_and_one() -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(2))
    for cable in (-1, 3):
        with pytest.raises(ValueError, match=r"cable: expected 0\.\.2"):
            ring.cut(cable)
        with pytest.raises(ValueError, match=r"cable: expected 0\.\.2"):
            ring.mend(cable)


def test_a_lost_link_is_counted_at_the_port_that_lost_it() -> None:
    ring = RingSegment(Slave(Loopback()) for _ in range(2))
    first, last = (slave.esc.memory for slave in ring.slaves)
    ring.connect(0, False)
    ring.connect(0, False)
    ring.cut(2)
    ring.cut(2)
    ring.connect(1, False)
    assert list(first[Register.LOST_LINKS : Register.LOST_LINKS.end]) == [1, 0, 0, 0]
    assert list(last[Register.LOST_LINKS : Register.LOST_LINKS.end]) == [0, 2, 0, 0]


@pytest.mark.parametrize("cable", range(4))
def test_frames_are_the_clock_once_whatever_is_cut(cable: int) -> None:
    ring = RingSegment((Slave(Loopback()) for _ in range(3)), cycle_ns=1000)
    exchange = EthercatFrame([Datagram(DatagramCommand.LRW, 0, b"\0")]).encode()
    ring.cut(cable)
    for cycle in range(1, 4):
        for adapter in (0, 1):
            ring.process_from(adapter, exchange)
        assert ring.time.now_ns == 1000 * cycle


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
