"""EEPROM: words and images, owners, errors."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat.master.eeprom_client import EepromClient, whole_image
from achse.ethercat.master.errors import EepromTrouble
from achse.ethercat.master.sii_reader import read_sii


def test_an_image_is_read_to_its_end(bus: Callable[..., Any]) -> None:
    ours = bus(2).up(AlState.PREOP)
    eeprom = EepromClient(1002)
    ours.do(eeprom.claim())
    image = ours.do(eeprom.image())
    content = read_sii(image)
    assert (content.valid, content.damage, content.serial_number) == (True, "", 1)
    stored = bytes(ours.segment.slaves[1].esc.eeprom.image)
    assert stored.startswith(image)
    assert set(stored[len(image) :]) == {0xFF}


@pytest.mark.parametrize("kibit", [2, 8, 32, 64])
def test_content_has_the_size_that_the_eeprom_reports(bus: Callable[..., Any], kibit: int) -> None:
    ours = bus(2).up(AlState.PREOP)
    memory = ours.segment.slaves[1].esc.eeprom.image
    memory[0x7C:0x7E] = (kibit - 1).to_bytes(2, "little")
    memory.extend(b"\x5a" * 8192)
    whole = ours.do(whole_image(1))
    assert whole == bytes(memory[: kibit * 128])


def test_words_are_written(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    eeprom = EepromClient(1001)
    ours.do(eeprom.claim())
    ours.do(eeprom.write(0x100, b"abcdef"))
    assert ours.do(eeprom.read(0x0FF, 5))[2:8] == b"abcdef"
    ours.do(eeprom.reload())
    ours.do(eeprom.hand_over())


def test_what_cannot_be_is_refused(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    eeprom = EepromClient(1001)
    ours.do(eeprom.claim())
    with pytest.raises(EepromTrouble, match="words of 2 bytes"):
        ours.do(eeprom.write(0, b"a"))
    with pytest.raises(EepromTrouble, match="got 65536"):
        ours.do(eeprom.read(65536, 1))
    with pytest.raises(EepromTrouble, match="after 3 tries"):
        ours.do(eeprom.write(0x7000, b"ab"))  # behind the memory
