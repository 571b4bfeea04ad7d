"""Descriptions are read from an application's own dictionary."""

from achse.codes import AbortCode, SdoAbort
from achse.ethercat import Loopback, describe
from achse.ethercat.description import LAYOUT, OPERATION_MODES
from achse.ethercat.dictionary import DictionaryObject


def test_pdos_come_from_mapping_and_assignment() -> None:
    description = describe(Loopback(2))
    (rx,), (tx,) = description.rx_pdos, description.tx_pdos
    assert (rx.index, rx.sync_manager, rx.fixed) == (0x1600, 2, True)
    assert (tx.index, tx.sync_manager, tx.fixed) == (0x1A00, 3, True)
    assert [(each.index, each.subindex, each.bits, each.name) for each in rx.entries] == [
        (0x7000, 1, 8, "Outputs: Output 0"),
        (0x7000, 2, 8, "Outputs: Output 1"),
    ]
    assert (description.output_size, description.input_size) == (2, 2)


def test_identity_and_name() -> None:
    application = Loopback(name="something", serial_number=77)
    description = describe(application)
    assert description.name == "something"
    assert (description.vendor_id, description.product_code) == (0, 0x100B)
    assert (description.revision_number, description.serial_number) == (1, 77)


class WithoutAssignment(Loopback):
    def objects(self) -> tuple[DictionaryObject, ...]:
        return tuple(each for each in super().objects() if each.index not in (0x1C12, 0x7000))


def test_what_is_not_assigned_has_no_sync_manager_and_unknown_objects_no_name() -> None:
    (rx,) = describe(WithoutAssignment(1)).rx_pdos
    assert rx.sync_manager is None
    assert rx.entries[0].name == ""


class Unreadable(Loopback):
    def read_object(self, index: int, subindex: int) -> bytes:
        raise SdoAbort(AbortCode.HARDWARE)


def test_an_unreadable_mapping_is_empty() -> None:
    assert describe(Unreadable(1)).rx_pdos[0].entries == ()


def test_the_layouts_areas_do_not_touch() -> None:
    areas = [LAYOUT.mailbox_out, LAYOUT.mailbox_in, LAYOUT.outputs, LAYOUT.inputs]
    buffers = [1, 1, 3, 3]
    for (one, count), other in zip(zip(areas, buffers, strict=True), areas[1:], strict=False):
        assert one.start + count * one.length <= other.start


def test_modes_are_free_run_and_dc() -> None:
    """001 §2.5; the activation word is 0x0981 above 0x0980: SYNC0 only."""
    assert [mode.assign_activate for mode in OPERATION_MODES] == [0x0000, 0x0300]
