"""What is found: counts, identities, and which configured slave each one is."""

from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import DatagramCommand
from achse.ethercat.master.configuration import SlaveConfiguration
from achse.ethercat.master.inspection import (
    count_slaves,
    inspect,
    match,
    same_device,
    scattered_reads,
)
from achse.ethercat.registers import Register


def box(product: int, optional: bool = False) -> SlaveConfiguration:
    return SlaveConfiguration("box", 1, product, optional=optional)


def identity(product: int) -> tuple[int, int, int, int]:
    return (1, product, 7, 8)


def test_revisions_are_compared_when_requested() -> None:
    slave = SlaveConfiguration("box", 1, 2, 6)
    assert same_device(slave, (1, 2, 7, 0))
    assert not same_device(slave, (1, 2, 7, 0), True)
    assert not same_device(SlaveConfiguration("box", 1, 2, 0, 9), (1, 2, 7, 8))


def test_optional_slaves_may_be_missing_others_not() -> None:
    slaves = [box(1), box(2, optional=True), box(3)]
    assert match(slaves, [identity(1), identity(2), identity(3)]) == [0, 1, 2]
    assert match(slaves, [identity(1), identity(3)]) == [0, 2]
    assert match(slaves, [identity(1), identity(9), identity(3)]) == [0, None, None]
    assert match([box(1), box(2), box(3)], [identity(1), identity(9), identity(3)]) == [0, None, 2]
    assert match([box(1)], [identity(1), identity(1)]) == [0, None]


@given(st.lists(st.integers(0, 3), max_size=8), st.lists(st.integers(0, 3), max_size=8))
def test_each_configured_slave_is_found_once_and_in_order(
    wanted: list[int], there: list[int]
) -> None:
    slaves = [box(each) for each in wanted]
    places = [
        each for each in match(slaves, [identity(each) for each in there]) if each is not None
    ]
    assert places == sorted(set(places))


def test_a_slave_is_described(bus: Callable[..., Any]) -> None:
    ours = bus(3)
    assert ours.do(count_slaves()) == 3
    ours.until(lambda: ours.master.supervision.link)
    facts = ours.do(inspect(1003))
    assert (facts.fmmus, facts.sync_managers, facts.has_clock) == (3, 4, True)
    assert facts.identity[3] == 2
    answers = ours.do(scattered_reads([1001, 77, 1003], Register.TYPE, 1, DatagramCommand.FPRD))
    assert answers == [b"\x11", None, b"\x11"]
