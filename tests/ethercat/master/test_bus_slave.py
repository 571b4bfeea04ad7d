"""A slave as the master sees it: entries as numbers, whatever their bits."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import Loopback, describe
from achse.ethercat.master.bus_slave import BusSlave, SlaveFacts
from achse.ethercat.master.configuration import from_description


def slave(bits: list[int]) -> BusSlave:
    """A slave whose outputs and inputs are the same memory, with entries of these bits."""
    entries = [(0x7000, number, each) for number, each in enumerate(bits, 1)]
    configuration = from_description(describe(Loopback())).with_entries(entries, entries)
    memory = memoryview(bytearray(sum(bits) + 7 >> 3))
    return BusSlave(0, 1001, configuration, memory, memory, (None, None), lambda slave, data: None)


@given(st.data(), st.lists(st.integers(1, 64), min_size=1, max_size=12))
def test_each_entry_keeps_its_value(data: st.DataObject, bits: list[int]) -> None:
    box = slave(bits)
    values = [data.draw(st.integers(0, (1 << each) - 1)) for each in bits]
    for number in data.draw(st.permutations(range(len(bits)))):
        box.write_output(0x7000, number + 1, values[number])
    for number, value in enumerate(values):
        assert box.read_output(0x7000, number + 1) == value
        assert box.read_input(0x7000, number + 1) == value
        signed = box.read_input(0x7000, number + 1, signed=True)
        assert signed % (1 << bits[number]) == value
        assert -(1 << bits[number] - 1) <= signed < 1 << bits[number] - 1


def test_what_is_not_mapped_is_a_key_error() -> None:
    box = slave([8])
    with pytest.raises(KeyError):
        box.read_input(0x6041)
    with pytest.raises(KeyError):
        box.write_output(0x6040, 0, 1)


def test_features_by_their_bits() -> None:
    facts = SlaveFacts(features=0x01FC)
    assert facts.has_clock
    assert facts.wide_clock
    assert facts.logical_read_write
    assert not SlaveFacts(features=0x0200).logical_read_write
    assert not slave([8]).operational
