"""Mapping and assignment by SDO: the order of the standard, and what is refused."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus, SdoAbort
from achse.ethercat.master.esi_reader import read_esi
from achse.ethercat.virtual import VirtualDevice
from tests.ethercat.virtual.esi_text import ANALOG, esi


def made() -> VirtualDevice:
    device = VirtualDevice(read_esi(esi(ANALOG))[0])
    device.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    return device


def refused(do: Callable[[], object]) -> AbortCode:
    with pytest.raises(SdoAbort) as abort:
        do()
    return abort.value.code


@given(order=st.permutations([0x1A00, 0x1A02]))
def test_assignment_changes_the_size(order: list[int]) -> None:
    device = made()
    assert device.input_size == 4
    device.write_object(0x1C13, 0, b"\0")
    assert device.input_size == 0
    for number, index in enumerate(order, 1):
        device.write_object(0x1C13, number, index.to_bytes(2, "little"))
    device.write_object(0x1C13, 0, b"\x02")
    assert device.input_size == 8
    assert device.read_object(0x1C13, 1) == order[0].to_bytes(2, "little")


def test_mapping_takes_objects_of_its_direction() -> None:
    device = made()
    device.write_object(0x1A00, 0, b"\0")
    device.write_object(0x1A00, 1, (0x6000_0210).to_bytes(4, "little"))
    device.write_object(0x1A00, 2, (0x0000_0008).to_bytes(4, "little"))
    device.write_object(0x1A00, 0, b"\x02")
    assert device.input_size == 3
    for value, code in (
        (0x7000_0110, AbortCode.NOT_MAPPABLE),
        (0x6000_0208, AbortCode.NOT_MAPPABLE),
        (0x6FFF_0110, AbortCode.NO_OBJECT),
        (0x6000_0910, AbortCode.NO_SUBINDEX),
    ):
        device.write_object(0x1A00, 0, b"\0")
        device.write_object(0x1A00, 1, value.to_bytes(4, "little"))
        assert refused(lambda: device.write_object(0x1A00, 0, b"\x01")) is code


def test_lists_are_changed_in_their_order_and_state() -> None:
    device = made()
    write = device.write_object
    assert refused(lambda: write(0x1C13, 1, b"\x02\x1a")) is AbortCode.UNSUPPORTED_ACCESS
    write(0x1C13, 1, b"\x00\x1a")  # what is there already
    assert refused(lambda: write(0x1A02, 0, b"\0")) is AbortCode.READ_ONLY
    assert refused(lambda: write(0x1C13, 0, b"\0\0")) is AbortCode.LENGTH
    assert refused(lambda: write(0x1C13, 0, b"\xff")) is AbortCode.VALUE_RANGE
    assert refused(lambda: write(0x1C13, 99, b"\0\0")) is AbortCode.NO_SUBINDEX
    device.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    assert refused(lambda: write(0x1C13, 0, b"\0")) is AbortCode.DEVICE_STATE
