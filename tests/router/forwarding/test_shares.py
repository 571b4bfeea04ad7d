"""Shares of hosts: never more together than eight windows, but for one request of each."""

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Frame
from achse.router.forwarding.shares import (
    FEW_RESOURCES,
    HOST_RESOURCES,
    HOST_WINDOW,
    HOST_WINDOW_BYTES,
    WINDOW,
    WINDOW_BYTES,
    HostShares,
)


class Connection:
    def __init__(self, host: str) -> None:
        self.peer_host = host

    def deliver(self, frame: Frame) -> bool:
        return True


@given(st.lists(st.tuples(st.booleans(), st.sampled_from(("a", "b"))), max_size=60))
def test_windows_of_a_host_are_bounded_together(steps: list[tuple[bool, str]]) -> None:
    shares, open_ = HostShares(), [Connection("c")]
    of_c = shares.join(open_[0])
    for joins, host in steps:
        here = [each for each in open_ if each.peer_host == host]
        if joins:
            open_.append(Connection(host))
            share = shares.join(open_[-1])
            count = share.connections
            assert count == len(here) + 1
            assert 1 <= share.window <= WINDOW
            assert share.window_bytes <= WINDOW_BYTES
            assert share.window * count <= max(HOST_WINDOW, count)
            assert share.window_bytes * count <= HOST_WINDOW_BYTES
            assert share.resources * count <= max(HOST_RESOURCES, FEW_RESOURCES * count)
        elif here:
            open_.remove(here[0])
            shares.leave(here[0])
        assert len(shares) == len({each.peer_host for each in open_})
        assert (of_c.window, of_c.window_bytes) == (WINDOW, WINDOW_BYTES)
    shares.clear()
    assert len(shares) == 0
