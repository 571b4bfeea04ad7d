"""A switch: frames go where their address is, to all until that is known."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.ethernet_switch import EthernetSwitch


def mac(number: int) -> bytes:
    return bytes((2, 0, 0, 0, number >> 8, number & 0xFF))


def frame(target: bytes, source: bytes) -> bytes:
    return target + source + b"\x08\x00data"


@given(
    st.integers(1, 5),
    st.lists(st.tuples(st.integers(0, 4), st.integers(0, 6), st.booleans()), max_size=30),
)
def test_frames_reach_their_address_alone(count: int, sent: list[tuple[int, int, bool]]) -> None:
    """Stations sit at fixed ports; each frame is from the station of its port, to any or to all."""
    switch = EthernetSwitch()
    ports = [switch.attach(str(number)) for number in range(count)]
    known: set[int] = set()
    for origin, target, everybody in sent:
        origin %= count
        data = frame(b"\xff" * 6 if everybody else mac(target), mac(origin))
        switch.send(ports[origin], data)
        known.add(origin)
        alone = not everybody and target in known
        expected = {target} if alone else set(range(count))
        for number, port in enumerate(ports):
            got = list(port.waiting)
            port.waiting.clear()
            assert got == ([data] if number in expected and number != origin else [])


def test_a_port_that_is_not_read_keeps_the_newest() -> None:
    switch = EthernetSwitch()
    here, there = switch.attach("here"), switch.attach("there")
    for number in range(70):
        switch.send(here, frame(mac(1), mac(2)) + bytes((number,)))
    assert (len(there.waiting), there.dropped, there.received) == (64, 6, 70)
    assert there.waiting[-1][-1] == 69


def test_addresses_of_a_port_that_is_gone_are_forgotten() -> None:
    switch = EthernetSwitch()
    came: list[bytes] = []
    one, two = switch.attach("one"), switch.attach("two", came.append)
    switch.send(one, frame(mac(9), mac(1)))
    switch.detach(one)
    switch.detach(one)
    three = switch.attach("three")
    switch.send(two, frame(mac(1), mac(2)))
    assert len(three.waiting) == 1
    with pytest.raises(ValueError, match="one is not at this switch"):
        switch.send(one, frame(mac(1), mac(2)))
    with pytest.raises(ValueError, match="14 to 1518 bytes"):
        switch.send(two, b"short")


def test_it_learns_a_bounded_number_of_addresses() -> None:
    switch = EthernetSwitch()
    here, there, aside = (switch.attach(name) for name in ("here", "there", "aside"))
    for number in range(1100):
        switch.send(here, frame(mac(5000), mac(number)))
    for port in (there, aside):
        port.waiting.clear()
    switch.send(there, frame(mac(0), mac(2000)))  # forgotten: goes to all
    switch.send(there, frame(mac(1099), mac(2000)))
    assert (len(here.waiting), len(aside.waiting)) == (2, 1)
