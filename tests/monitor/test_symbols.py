"""What passes about symbols gives names and types to all that passes afterwards."""

import struct
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec import ARRAY, BOOL, INT, LREAL, Struct, var
from achse.iec.datatypes import encode_types
from achse.iec.declare import iec_type
from achse.iec.describe import describe_type, types_within
from achse.iec.symbols import SymbolEntry, UploadInfo, encode_symbols
from achse.monitor.symbols import KnownSymbols

CLIENT = b"client 1"
GROUP = 0x4040


class ST_Pair(Struct):  # noqa: N801
    fX = var(LREAL)  # noqa: N815
    aY = var(ARRAY(INT, (1, 2), (0, 3)))  # noqa: N815
    bZ = var(BOOL)  # noqa: N815


PAIR = iec_type(ST_Pair)
TYPES = encode_types(map(describe_type, types_within([PAIR])))
TABLE = encode_symbols(
    [
        SymbolEntry.of("GVL.nInt", INT, GROUP, 96),
        SymbolEntry.of("GVL.stPair", PAIR, GROUP, 104),
        SymbolEntry.of("GVL.größe", INT, GROUP, 200),
    ]
)
END = 104 + PAIR.size


def type_name(known: KnownSymbols, name: str) -> str:
    type = known.type_of(name)
    return "" if type is None else type.name


@pytest.fixture
def known() -> KnownSymbols:
    symbols = KnownSymbols()
    symbols.learn_table(CLIENT, 0xF00B, 0, TABLE)
    symbols.learn_table(CLIENT, 0xF00E, 0, TYPES)
    return symbols


@pytest.mark.parametrize(
    ("name", "type"),
    [
        ("GVL.nInt", "INT"),
        ("gvl.NINT", "INT"),
        ("GVL.nInt.3", "BIT"),
        ("GVL.stPair", "ST_Pair"),
        ("GVL.stPair.fX", "LREAL"),
        ("GVL.stPair.aY[2,3]", "INT"),
        ("GVL.stPair.nothing", ""),
        ("GVL.stPair.aY[3,0]", ""),
        ("GVL.other", ""),
        ("", ""),
    ],
)
def test_types_of_symbols_and_of_their_parts(known: KnownSymbols, name: str, type: str) -> None:
    assert type_name(known, name) == type


@pytest.mark.parametrize(
    ("offset", "length", "name"),
    [
        (96, 2, "GVL.nInt"),
        (96, 4, "GVL.nInt"),
        (97, 1, ""),
        (104, PAIR.size, "GVL.stPair"),
        (104, 8, "GVL.stPair.fX"),
        (104, 4, "GVL.stPair"),
        (112, 2, "GVL.stPair.aY[1,0]"),
        (126, 2, "GVL.stPair.aY[2,3]"),
        (112, 16, "GVL.stPair.aY"),
        (112, 4, ""),
        (128, 1, "GVL.stPair.bZ"),
        (END, 2, ""),
        (0, 2, ""),
    ],
)
def test_an_address_is_a_symbol_or_the_part_of_one(
    known: KnownSymbols, offset: int, length: int, name: str
) -> None:
    assert known.at(GROUP, offset, length) == name
    assert known.at(GROUP + 1, offset, length) == ""


def test_a_part_that_was_requested_by_itself_hides_nothing(known: KnownSymbols) -> None:
    assert known.at(GROUP, 126, 2) == "GVL.stPair.aY[2,3]"
    known.learn_symbol(SymbolEntry.of("GVL.stPair.fX", LREAL, GROUP, 104))
    known.learn_symbol(SymbolEntry.of("GVL.stPair.aY[1,0]", INT, GROUP, 112))
    assert known.at(GROUP, 126, 2) == "GVL.stPair.aY[2,3]"
    assert known.at(GROUP, 104, 8) == "GVL.stPair.fX"


@given(st.lists(st.integers(1, len(TABLE)), max_size=6), st.booleans())
def test_a_table_in_pieces_of_any_size_reports_the_same(cuts: list[int], disturbed: bool) -> None:
    known = KnownSymbols()
    known.learn_table(CLIENT, 0xF00E, 0, TYPES)
    edges = [0, *sorted(set(cuts)), len(TABLE)]
    for start, end in pairwise(edges):
        known.learn_table(CLIENT, 0xF00B, 0x8000_0000 | start, TABLE[start:end])
        if disturbed:  # by another client, and by a piece out of order
            known.learn_table(b"client 2", 0xF00B, 0x8000_0000, TABLE[:10])
            known.learn_table(CLIENT, 0xF00B, 0x8000_0000 | 5_000, b"\xff" * 10)
    assert type_name(known, "GVL.nInt") == "INT"
    assert known.at(GROUP, 126, 2) == "GVL.stPair.aY[2,3]"
    assert type_name(known, "GVL.größe") == "INT"


def test_names_in_utf_8() -> None:
    known = KnownSymbols()
    known.learn_info(UploadInfo(1, 100, flags=5).encode())
    entry = SymbolEntry.of("GVL.größe", INT, GROUP, 0)
    known.learn_table(CLIENT, 0xF009, 0, entry.encode("utf-8"))
    assert known.at(GROUP, 0, 2) == "GVL.größe"
    assert known.text("GVL.größe\0".encode()) == "GVL.größe"


def test_handles_with_and_without_type() -> None:
    known = KnownSymbols()
    known.learn_handle("A.x", struct.pack("<I", 7))
    known.learn_handle("A.y", struct.pack("<IIIH", 8, 2, 2, 3) + b"INT\0")
    known.learn_handle("A.z", b"\1")
    assert [known.handle_name(handle) for handle in (7, 8, 9)] == ["A.x", "A.y", ""]
    assert (type_name(known, "A.x"), type_name(known, "A.y")) == ("", "INT")


def test_a_place_without_a_type_has_a_name(known: KnownSymbols) -> None:
    known.learn_place("GVL.fNew", struct.pack("<III", GROUP, 300, 8))
    known.learn_place("GVL.nInt", struct.pack("<III", GROUP, 400, 2))
    known.learn_place("GVL.bad", b"\1")
    assert known.at(GROUP, 300, 8) == "GVL.fNew"
    assert known.at(GROUP, 400, 2) == ""  # the entry is known, and says more


def test_types_from_another_device_fill_what_is_missing(known: KnownSymbols) -> None:
    other = KnownSymbols()
    other.learn_symbol(SymbolEntry.of("GVL.nInt", LREAL, GROUP, 8))
    other.complete(known)
    assert type_name(other, "GVL.nInt") == "LREAL"
    assert type_name(other, "GVL.stPair.aY[1,1]") == "INT"
    assert other.at(GROUP, 104, PAIR.size) == ""  # there it may lie elsewhere


def test_with_another_version_all_is_forgotten_but_not_with_the_first(known: KnownSymbols) -> None:
    known.is_whole = True
    for version in (b"\1", b"\1"):
        known.learn_version(version)
        assert known.at(GROUP, 96, 2) == "GVL.nInt"
    known.learn_version(b"\2")
    assert (known.at(GROUP, 96, 2), type_name(known, "GVL.nInt"), known.is_whole) == ("", "", False)


@given(
    st.lists(
        st.tuples(
            st.sampled_from((0xF009, 0xF00B, 0xF00E, 0xF011)),
            st.one_of(st.just(0), st.integers(0x8000_0000, 0x8000_0040)),
            st.one_of(
                st.binary(max_size=60),
                st.integers(0, len(TABLE)).map(lambda cut: TABLE[cut:] + TABLE[:cut]),
            ),
        ),
        max_size=8,
    ),
    st.binary(max_size=60),
)
def test_whatever_a_target_reports_nothing_is_raised(
    reports: list[tuple[int, int, bytes]], data: bytes
) -> None:
    known = KnownSymbols()
    for group, offset, table in reports:
        known.learn_table(CLIENT, group, offset, table)
    known.learn_handle("x", data)
    known.learn_place("y", data)
    known.learn_info(data)
    for name in ("x", "y", "GVL.nInt", known.text(data), known.at(GROUP, 96, 2)):
        known.type_of(name)
