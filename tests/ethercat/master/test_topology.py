"""Trees from DL status, delays from receive times."""

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import Loopback, Segment, Slave
from achse.ethercat.master.topology import build_tree, open_ports, propagation_delays
from achse.ethercat.registers import Register

MIDDLE, LAST, FORK = 0x5A31, 0x5611, 0x6A71


def status(*ports: int) -> int:
    """DL status with communication at these ports."""
    return sum(1 << 9 + 2 * port for port in ports)


def test_ports_come_in_the_order_of_frames() -> None:
    assert open_ports(MIDDLE) == (0, 1)
    assert open_ports(LAST) == (0,)
    assert open_ports(status(0, 1, 2, 3)) == (0, 3, 1, 2)


def test_a_line_and_a_tree() -> None:
    line = build_tree([MIDDLE, MIDDLE, LAST])
    assert [(each.parent, each.parent_port) for each in line] == [(None, 0), (0, 1), (1, 1)]
    # slave 0 has 1 and 2 at port 3, and 3 at port 1
    tree = build_tree([status(0, 3, 1), status(0, 1), status(0), status(0)])
    assert [(each.parent, each.parent_port) for each in tree] == [
        (None, 0),
        (0, 3),
        (1, 1),
        (0, 1),
    ]
    assert tree[0].children == {3: 1, 1: 3}


def test_statuses_that_fit_to_nothing_make_a_line() -> None:
    assert [each.parent for each in build_tree([0, 0, 0])] == [None, 0, 1]


def test_without_clocks_there_is_no_delay() -> None:
    assert propagation_delays(build_tree([MIDDLE, LAST]), [None, None]) == [0, 0]


def test_times_wrap() -> None:
    places = build_tree([MIDDLE, LAST])
    times = [[0xFFFF_FF00, 0x0000_0158, 0, 0], [7, 7, 7, 7]]
    assert propagation_delays(places, times) == [0, 300]


@given(st.lists(st.tuples(st.integers(0, 9), st.sampled_from([1, 2, 3])), max_size=7))
def test_delays_of_drawn_trees_are_those_of_the_segment(
    branches: Sequence[tuple[int, int]],
) -> None:
    """The master measures what the segment was built with, whatever its shape."""
    segment = Segment([Slave(Loopback())])
    taken: set[tuple[int, int]] = set()
    for parent, port in branches:
        at = parent % len(segment.slaves)
        if (at, port) not in taken:
            taken.add((at, port))
            segment.attach(Slave(Loopback()), segment.slaves[at], port)
    order = segment.reachable
    latches = [slave.esc.clock.port_delays for slave in order]
    times = [[each or 0 for each in latch] for latch in latches]
    statuses = [
        int.from_bytes(slave.esc.read(Register.DL_STATUS, 2) or b"", "little") for slave in order
    ]
    measured = propagation_delays(build_tree(statuses), times)
    first = order[0].esc.clock.arrival_ns
    assert measured == [slave.esc.clock.arrival_ns - first for slave in order]
