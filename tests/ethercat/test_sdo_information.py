"""SDO information about a dictionary."""

import struct

import pytest

from achse.codes import AbortCode
from achse.ethercat.dictionary import DictionaryEntry, DictionaryObject
from achse.ethercat.loopback import Loopback
from achse.ethercat.sdo_information import LIST_TYPES, SdoInformation

ALL = 1


def server() -> SdoInformation:
    return SdoInformation({each.index: each for each in Loopback(4).objects()})


def ask(operation: int, data: bytes, capacity: int = 200) -> list[tuple[int, int, bytes]]:
    """Operation with its incomplete bit, fragments left, data of each reply."""
    replies = server().answer(struct.pack("<BBH", operation, 0, 0) + data, capacity)
    assert all(len(reply) <= capacity for reply in replies)
    return [(reply[0], reply[2] | reply[3] << 8, reply[4:]) for reply in replies]


def test_the_list_of_all_objects() -> None:
    ((operation, left, data),) = ask(1, b"\x01\x00")
    kind, *indices = struct.unpack(f"<{len(data) // 2}H", data)
    assert (operation, left, kind) == (2, 0, ALL)
    assert indices == [each.index for each in Loopback(4).objects()]


def test_long_lists_come_in_fragments_and_name_their_type_once() -> None:
    replies = ask(1, b"\x01\x00", capacity=13)
    assert [left for _, left, _ in replies] == list(range(len(replies) - 1, -1, -1))
    assert [operation for operation, _, _ in replies] == [0x82] * (len(replies) - 1) + [2]
    whole = b"".join(data for _, _, data in replies)
    assert whole == ask(1, b"\x01\x00")[0][2]


@pytest.mark.parametrize(("kind", "expected"), [(2, [0x7000]), (3, [0x6000]), (4, []), (5, [])])
def test_lists_by_use(kind: int, expected: list[int]) -> None:
    ((_, _, data),) = ask(1, bytes((kind, 0)))
    assert list(struct.unpack(f"<{len(data) // 2}H", data)) == [kind, *expected]


def test_the_lengths_of_all_lists() -> None:
    ((_, _, data),) = ask(1, b"\x00\x00")
    kind, *lengths = struct.unpack("<6H", data)
    assert kind == 0
    assert lengths == [(len(ask(1, bytes((kind, 0)))[0][2]) - 2) // 2 for kind in LIST_TYPES]


def test_an_object() -> None:
    assert ask(3, b"\x18\x10") == [
        (4, 0, struct.pack("<HHBB", 0x1018, 0x23, 4, 9) + b"Identity"),
    ]


def test_an_entry() -> None:
    assert ask(5, b"\x00\x70\x02\x07") == [
        (6, 0, struct.pack("<HBBHHH", 0x7000, 2, 7, 5, 8, 0x7F) + b"Output 1"),
    ]


def test_an_entrys_values_come_in_the_order_of_their_bits() -> None:
    entry = DictionaryEntry(0, "Limit", 6, 16, 0x3F, b"de", b"mi", b"ma")
    one = SdoInformation({0x2000: DictionaryObject(0x2000, "Limit", 7, 6, (entry,))})
    (reply,) = one.answer(struct.pack("<BxHHBB", 5, 0, 0x2000, 0, 0xFF), 200)
    assert reply[7] == 0x77  # no unit
    assert reply[14:] == b"demimaLimit"


def test_a_gap_between_entries_is_described_as_nothing() -> None:
    """Masters walk the subindices up to the last; an error for each gap would stop them."""
    entries = (DictionaryEntry(0, "Count", 5, 8, 7), DictionaryEntry(2, "Limit", 6, 16, 0x3F))
    one = SdoInformation({0x10F1: DictionaryObject(0x10F1, "Settings", 9, 0, entries)})
    (reply,) = one.answer(struct.pack("<BxHHBB", 5, 0, 0x10F1, 1, 7), 200)
    assert reply == struct.pack("<BxHHBBHHH", 6, 0, 0x10F1, 1, 0, 0, 0, 0)
    (reply,) = one.answer(struct.pack("<BxHHBB", 5, 0, 0x10F1, 3, 7), 200)
    assert reply[0] == 7


@pytest.mark.parametrize(
    ("operation", "data", "code"),
    [
        (1, "0600", AbortCode.UNSUPPORTED_ACCESS),
        (3, "0050", AbortCode.NO_OBJECT),
        (5, "0050 00 07", AbortCode.NO_OBJECT),
        (5, "1810 05 07", AbortCode.NO_SUBINDEX),
        (5, "1810", AbortCode.UNSUPPORTED_ACCESS),
        (2, "0100", AbortCode.UNSUPPORTED_ACCESS),
        (0x7F, "0100", AbortCode.UNSUPPORTED_ACCESS),
    ],
)
def test_errors(operation: int, data: str, code: AbortCode) -> None:
    assert ask(operation, bytes.fromhex(data)) == [(7, 0, int(code).to_bytes(4, "little"))]


def test_long_names_end_with_the_message() -> None:
    text = DictionaryObject(0x2000, "n" * 300, 7, 9, (DictionaryEntry(0, "m" * 300, 9, 8, 7),))
    one = SdoInformation({0x2000: text})
    for request in (struct.pack("<BxHH", 3, 0, 0x2000), struct.pack("<BxHHBB", 5, 0, 0x2000, 0, 7)):
        (reply,) = one.answer(request, 64)
        assert len(reply) == 64
