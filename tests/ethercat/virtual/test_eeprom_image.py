"""The EEPROM of a device: read again it is what the file says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.description import Pdo
from achse.ethercat.master.esi_reader import EsiError, read_esi
from achse.ethercat.master.sii_reader import read_sii
from achse.ethercat.virtual import make_slave
from tests.ethercat.virtual.esi_text import INPUTS, VENDOR, device, drawn_devices, esi

SMALL = 256
"""Bytes of an EEPROM with no room for many PDOs."""


def _entries(pdo: Pdo) -> list[tuple[int, ...]]:
    return [(pdo.index,), *((e.index, e.subindex, e.bits) for e in pdo.entries)]


@given(text=drawn_devices(), alias=st.integers(0, 0xFFFF), serial=st.integers(0, 0xFFFF_FFFF))
def test_image_is_read_as_it_was_made(text: str, alias: int, serial: int) -> None:
    device = read_esi(esi(text))[0]
    slave = make_slave(device, alias=alias, serial_number=serial)
    content = read_sii(bytes(slave.esc.eeprom.image))
    assert content.valid
    assert not content.damage
    assert (content.vendor_id, content.product_code, content.revision_number) == (
        VENDOR, device.product_code, device.revision_number,
    )  # fmt: skip
    assert (content.alias, content.serial_number) == (alias, serial)
    assert content.order == device.type_name.encode("ascii", "replace").decode()
    assert [each.area.start for each in content.sync_managers] == [
        each.area.start for each in device.sync_managers
    ]
    rooms = len(slave.esc.eeprom.image), device.eeprom_size
    left_out = "CoE" in device.protocols and rooms[1] == SMALL
    for result, wanted in ((content.rx_pdos, device.outputs), (content.tx_pdos, device.inputs)):
        if result or not left_out:
            assert [_entries(each) for each in result] == [_entries(each.pdo) for each in wanted]
    assert [(each.name, each.assign_activate) for each in content.modes] == [
        (each.name, each.assign_activate) for each in device.modes
    ]
    assert rooms[0] >= rooms[1]


def test_entries_that_do_not_fit_into_an_eeprom_are_refused() -> None:
    entries = "<Entry><Index>0</Index><BitLen>1</BitLen></Entry>" * 16_400
    text = f'{INPUTS}<TxPdo Sm="0"><Index>#x1A00</Index>{entries}</TxPdo>'
    with pytest.raises(EsiError, match="do not fit into an EEPROM"):
        make_slave(read_esi(esi(device(text)))[0])
