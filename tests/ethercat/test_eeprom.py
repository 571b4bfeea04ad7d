"""The EEPROM interface, as masters use it."""

import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.eeprom import checksum

BUSY = 0x8000
WRITE, READ, RELOAD = 0x0201, 0x0100, 0x0400


def command(master: Any, control: int, address: int, data: bytes = b"") -> int:
    """Write control and address in one access, as masters do; status afterwards."""
    assert master.write(0x0502, struct.pack("<HI", control, address) + data) == 1
    return int(master.number(0x0502, 2))


def test_a_read_gives_eight_bytes_at_once(master: Any) -> None:
    status = command(master, READ, 8)
    assert status & 0x0040
    assert not status & BUSY
    vendor, product = struct.unpack("<II", master.read(0x0508, 8))
    identity = master.line[0].identity
    assert (vendor, product) == (identity.vendor_id, identity.product_code)


def test_control_address_and_data_are_read_in_one_access(master: Any) -> None:
    command(master, READ, 0x0A)
    control, address, product, revision = struct.unpack("<HIII", master.read(0x0502, 14))
    assert (control & 0x40, address) == (0x40, 0x0A)
    assert (product, revision) == (master.line[0].identity.product_code, 1)


def test_a_broadcast_reads_all(line: Callable[..., Any]) -> None:
    from achse.ethercat import DatagramCommand

    master = line(3)
    master.address()
    assert master.one(DatagramCommand.BWR, 0, 0x0502, struct.pack("<HI", READ, 0x0E)).counter == 3
    assert [master.number(0x0508, 4, 0x1001 + n) for n in range(3)] == [0, 1, 2]


def test_beyond_the_image_everything_is_ff(master: Any) -> None:
    command(master, READ, 0x10000)
    assert master.read(0x0508, 8) == b"\xff" * 8


def test_a_word_is_written_with_write_enable_in_the_same_access(master: Any) -> None:
    assert not command(master, WRITE, 0x100, b"\x34\x12") & 0x6000
    command(master, READ, 0x100)
    assert master.number(0x0508, 2) == 0x1234
    refused = command(master, WRITE & ~1, 0x100, b"\x00\x00")
    assert refused & 0x4000
    assert not command(master, READ, 0x100) & 0x4000
    assert master.number(0x0508, 2) == 0x1234


@pytest.mark.parametrize("wrong", [0x0300, 0x0500, 0x0700])
def test_an_unknown_command_is_an_error_until_the_next(master: Any, wrong: int) -> None:
    assert command(master, wrong, 0) & 0x2000
    assert not command(master, READ, 0) & 0x2000


def test_a_write_behind_the_end_is_an_error(master: Any) -> None:
    assert command(master, WRITE, 0x8000, b"\0\0") & 0x2000


def test_reload_takes_the_alias_over(master: Any) -> None:
    slave = master.segment.slaves[0]
    slave.esc.eeprom.image[8:10] = b"\x22\x11"
    slave.esc.eeprom.image[14] = checksum(slave.esc.eeprom.image)
    assert master.number(0x0012, 2) == 0
    command(master, RELOAD, 0)
    assert master.number(0x0012, 2) == 0x1122


def test_a_damaged_configuration_area_silences_the_application(master: Any) -> None:
    slave = master.segment.slaves[0]
    slave.esc.eeprom.image[0] ^= 0xFF
    assert command(master, RELOAD, 0) & 0x0800
    assert not master.number(0x0110, 2) & 1
    master.mailboxes()
    assert master.request(2) == (1, 0)
    slave.esc.eeprom.image[0] ^= 0xFF
    command(master, RELOAD, 0)
    assert master.request(2) == (2, 0)


@given(st.binary(min_size=14, max_size=20))
def test_the_checksum_is_the_remainder_of_a_division(words: bytes) -> None:
    """x^8 + x^2 + x + 1 divides the 14 bytes, the first inverted, and the checksum behind them."""
    rest = (int.from_bytes(words[:14]) ^ 0xFF << 8 * 13) << 8 | checksum(words)
    while rest.bit_length() > 8:
        rest ^= 0x107 << rest.bit_length() - 9
    assert rest == 0
