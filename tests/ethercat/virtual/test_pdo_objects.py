"""Mapping and assignment by SDO: the order of the standard, and what is refused."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus, SdoAbort
from achse.ethercat.master.esi_reader import EsiError, read_esi
from achse.ethercat.virtual import VirtualDevice
from achse.ethercat.virtual.pdo_objects import MOST_BITS
from tests.ethercat.virtual.esi_text import ANALOG, COE, INPUTS, device, esi, pdo


def preop_box() -> VirtualDevice:
    box = VirtualDevice(read_esi(esi(ANALOG))[0])
    box.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    return box


def refused(do: Callable[[], object]) -> AbortCode:
    with pytest.raises(SdoAbort) as abort:
        do()
    return abort.value.code


@given(order=st.permutations([0x1A00, 0x1A02]))
def test_assignment_changes_the_size(order: list[int]) -> None:
    box = preop_box()
    assert box.input_size == 4
    box.write_object(0x1C13, 0, b"\0")
    assert box.input_size == 0
    for number, index in enumerate(order, 1):
        box.write_object(0x1C13, number, index.to_bytes(2, "little"))
    box.write_object(0x1C13, 0, b"\x02")
    assert box.input_size == 8
    assert box.read_object(0x1C13, 1) == order[0].to_bytes(2, "little")


def test_pdo_beyond_the_assignments_is_a_pdo() -> None:
    """A file may place it anywhere."""
    text = ANALOG.replace("#x1A02", "#xE3EE")
    box = VirtualDevice(read_esi(esi(text.replace('Fixed="1"', "")))[0])
    box.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    box.write_object(0xE3EE, 0, b"\0")
    box.write_object(0xE3EE, 0, b"\1")
    box.write_object(0xE3EE, 0, b"\0")
    box.write_object(0xE3EE, 1, (0x7000_0110).to_bytes(4, "little"))
    assert refused(lambda: box.write_object(0xE3EE, 0, b"\1")) == AbortCode.NOT_MAPPABLE


def test_mapping_takes_objects_of_its_direction() -> None:
    box = preop_box()
    box.write_object(0x1A00, 0, b"\0")
    box.write_object(0x1A00, 1, (0x6000_0210).to_bytes(4, "little"))
    box.write_object(0x1A00, 2, (0x0000_0008).to_bytes(4, "little"))
    box.write_object(0x1A00, 0, b"\x02")
    assert box.input_size == 3
    for value, code in (
        (0x7000_0110, AbortCode.NOT_MAPPABLE),
        (0x6000_0208, AbortCode.NOT_MAPPABLE),
        (0x6FFF_0110, AbortCode.NO_OBJECT),
        (0x6000_0910, AbortCode.NO_SUBINDEX),
    ):
        box.write_object(0x1A00, 0, b"\0")
        box.write_object(0x1A00, 1, value.to_bytes(4, "little"))
        assert refused(lambda: box.write_object(0x1A00, 0, b"\x01")) is code


@given(st.integers(1, 32), st.sampled_from([1, 255, 30_000, 0xFFFF]), st.booleans())
def test_process_data_fit_into_a_sync_manager(count: int, bits: int, default: bool) -> None:
    """A file with more is refused, and so is an assignment of more."""
    managers = "<Sm/><Sm/><Sm/>" + INPUTS
    inputs = "".join(
        pdo(
            "TxPdo",
            0x1A00 + n,
            [(0x6000 + n, 1, bits, "Much", "")],
            **({"Sm": 3} if default else {}),
        )
        for n in range(count)
    )
    text = device(managers + inputs + COE + "</Mailbox>", name="Large")
    fits = count * bits <= MOST_BITS
    if default and not fits:
        with pytest.raises(EsiError, match="Large: SyncManager 3: expected 65535 bytes"):
            VirtualDevice(read_esi(esi(text))[0])
        return
    box = VirtualDevice(read_esi(esi(text))[0])
    box.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    box.write_object(0x1C13, 0, b"\0")
    for n in range(count):
        box.write_object(0x1C13, n + 1, (0x1A00 + n).to_bytes(2, "little"))
    if fits:
        box.write_object(0x1C13, 0, bytes((count,)))
        assert box.input_size == (count * bits + 7) // 8
    else:
        code = refused(lambda: box.write_object(0x1C13, 0, bytes((count,))))
        assert (code, box.input_size) == (AbortCode.PDO_LENGTH, 0)


def test_lists_are_changed_in_their_order_and_state() -> None:
    box = preop_box()
    write = box.write_object
    assert refused(lambda: write(0x1C13, 1, b"\x02\x1a")) is AbortCode.UNSUPPORTED_ACCESS
    write(0x1C13, 1, b"\x00\x1a")  # what is there already
    assert refused(lambda: write(0x1A02, 0, b"\0")) is AbortCode.READ_ONLY
    assert refused(lambda: write(0x1C13, 0, b"\0\0")) is AbortCode.LENGTH
    assert refused(lambda: write(0x1C13, 0, b"\xff")) is AbortCode.VALUE_RANGE
    assert refused(lambda: write(0x1C13, 99, b"\0\0")) is AbortCode.NO_SUBINDEX
    box.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    assert refused(lambda: write(0x1C13, 0, b"\0")) is AbortCode.DEVICE_STATE
