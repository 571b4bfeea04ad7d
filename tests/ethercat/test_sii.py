"""The SII image, read back by a reader written from its layout."""

import struct
from dataclasses import replace
from typing import Any

import pytest

from achse.ethercat import Loopback, build_sii, describe
from achse.ethercat.eeprom import checksum
from achse.ethercat.sii import SII_SIZE


@pytest.fixture
def image() -> bytes:
    return build_sii(describe(Loopback(4, name="slave", serial_number=0x1234)), alias=0x25)


def word(image: bytes, address: int, count: int = 1) -> tuple[int, ...]:
    return struct.unpack_from(f"<{count}H", image, 2 * address)


def categories(image: bytes) -> dict[int, bytes]:
    results: dict[Any, Any] = {}
    position = 0x80
    while True:
        kind, length = struct.unpack_from("<HH", image, position)
        if kind == 0xFFFF:
            return results
        results[kind] = image[position + 4 : position + 4 + 2 * length]
        position += 4 + 2 * length


def strings(image: bytes) -> list[str]:
    data = categories(image)[10]
    texts, position = [""], 1
    for _ in range(data[0]):
        size = data[position]
        texts.append(data[position + 1 : position + 1 + size].decode())
        position += 1 + size
    return texts


def test_configuration_area(image: bytes) -> None:
    assert word(image, 4) == (0x25,)
    assert word(image, 7) == (checksum(image),)
    assert image[1] & 0x0C == 0x0C  # DC units on
    assert not image[1] & 0x01  # no device emulation


def test_identity(image: bytes) -> None:
    assert struct.unpack_from("<4I", image, 16) == (0, 0x100B, 1, 0x1234)


def test_mailboxes(image: bytes) -> None:
    assert word(image, 0x14, 4) == (0, 0, 0, 0)  # no bootstrap
    assert word(image, 0x18, 5) == (0x1000, 256, 0x1100, 256, 0x0004)


def test_size_and_version(image: bytes) -> None:
    size, version = word(image, 0x3E, 2)
    assert ((size + 1) * 128, version) == (SII_SIZE, 1)
    assert len(image) == SII_SIZE


def test_categories_ascend_and_end(image: bytes) -> None:
    assert list(categories(image)) == [10, 30, 40, 41, 50, 51, 60]


def test_the_first_string_is_the_name(image: bytes) -> None:
    texts = strings(image)
    assert texts[1] == "slave"
    general = categories(image)[30]
    assert len(general) == 32
    assert texts[general[3]] == "slave"
    assert general[5] & 0x20  # complete access
    assert not general[11] & 0x02  # LRW works
    assert struct.unpack_from("<H", general, 16) == (0x0011,)


def test_fmmus_and_sync_managers(image: bytes) -> None:
    assert categories(image)[40] == b"\x01\x02\x03\xff"
    rows = list(struct.iter_unpack("<HHBBBB", categories(image)[41]))
    assert rows == [
        (0x1000, 256, 0x26, 0, 1, 1),
        (0x1100, 256, 0x22, 0, 1, 2),
        (0x1200, 4, 0x64, 0, 1, 3),
        (0x1300, 4, 0x20, 0, 1, 4),
    ]


def test_pdos(image: bytes) -> None:
    texts = strings(image)
    for kind, index, sync_manager, mapped in ((51, 0x1600, 2, 0x7000), (50, 0x1A00, 3, 0x6000)):
        data = categories(image)[kind]
        number, count, manager, _, name, flags = struct.unpack_from("<HBBBBH", data)
        assert (number, count, manager, flags) == (index, 4, sync_manager, 0x10)
        assert texts[name].endswith("mapping")
        entries = list(struct.iter_unpack("<HBBBBH", data[8:]))
        assert [entry[:2] for entry in entries] == [(mapped, n) for n in (1, 2, 3, 4)]
        assert all(entry[3:5] == (5, 8) for entry in entries)


def test_clock_modes(image: bytes) -> None:
    rows = list(struct.iter_unpack("<IiihHhBB4x", categories(image)[60]))
    assert [(row[4], row[5]) for row in rows] == [(0x0000, 0), (0x0300, 1)]
    assert [strings(image)[row[6]] for row in rows] == ["FreeRun", "DC"]


def test_what_does_not_fit_is_reported() -> None:
    description = describe(Loopback(4))
    pdos = tuple(
        replace(description.rx_pdos[0], index=0x1600 + n, name=f"mapping {n}") for n in range(200)
    )
    with pytest.raises(ValueError, match="of 4096 bytes"):
        build_sii(replace(description, rx_pdos=pdos))
