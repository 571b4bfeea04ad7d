"""Instance paths."""

# ruff: noqa: N815  (variables carry the prefixes of IEC programs)

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.declare import ARRAY, iec_type, method, pointer_to, reference_to, var
from achse.iec.derived import AliasType, InterfaceType
from achse.iec.elementary import BIT, BOOL, INT, LREAL, WORD
from achse.iec.errors import IecIndexError, IecPathError
from achse.iec.paths import (
    Bit,
    Deref,
    PathIndex,
    PathMember,
    PathMethod,
    ResolvedPath,
    follow,
    format_path,
    locate,
    parse_path,
    split_symbol,
)
from achse.iec.structs import FunctionBlock, Struct
from achse.iec.variables import Section, Variable


class Point(Struct, name="ST_Point"):
    x = var(LREAL)
    y = var(LREAL)


class Block(FunctionBlock, name="FB_Block"):
    wFlags = var(WORD)  # 8
    b0 = var(BIT)  # 10.0
    b1 = var(BIT)  # 10.1
    aGrid = var(ARRAY(INT, (-1, 1), (1, 2)))  # 12
    aaRow = var(ARRAY(ARRAY(INT, (0, 1)), (5, 6)))  # 24
    aPoints = var(ARRAY(AliasType("T_Point", Point.__iec__), (1, 3)))  # 32
    pPoint = var(pointer_to(Point))  # 80
    rPoint = var(reference_to(Point))  # 88
    iAny = var(InterfaceType("I_Any"))  # 96

    @method(BOOL)
    def Reset(self) -> bool:  # noqa: N802
        return True


BLOCK = iec_type(Block)


def test_the_steps_of_a_path() -> None:
    assert parse_path("MAIN.st.a[3].x") == (
        PathMember("MAIN"),
        PathMember("st"),
        PathMember("a"),
        PathIndex((3,)),
        PathMember("x"),
    )
    assert parse_path("a[ -1 , +2 ][007]") == (PathMember("a"), PathIndex((-1, 2)), PathIndex((7,)))
    assert parse_path("p^^.w.15") == (
        PathMember("p"),
        Deref(),
        Deref(),
        PathMember("w"),
        Bit(15),
    )
    assert parse_path("fb#Do") == (PathMember("fb"), PathMethod("Do"))
    assert parse_path("[1]") == (PathIndex((1,)),)
    assert parse_path(".Grün") == (PathMember("Grün"),)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("", "expected a name at position 0, got the end"),
        ("a.", "expected a name at position 2, got the end"),
        ("a..b", "expected a name at position 2, got '.b'"),
        ("a[", "expected an index at position 2"),
        ("a[x]", "expected an index at position 2, got 'x]'"),
        ("a[1", "expected ',' or ']' at position 3, got the end"),
        ("a[1;2]", "expected ',' or ']' at position 3"),
        ("a[1,]", "expected an index at position 4"),
        ("a b", r"expected '\.', '\[', '\^' or '#' at position 1"),
        ("a#", "expected a name at position 2"),
        ("a.100", "expected a bit number"),
        ("a[99999999999999999999]", "index 99999999999999999999 of .* is outside any array"),
        ("a[" + "9" * 10_000 + "]", "is outside any array"),
        ("a" + ".b" * 5_000, "a path has at most 256 steps"),
        ("ä" * 5_000 + "?", "at position 5000"),
    ],
    ids=range(15),
)
def test_what_is_no_path_is_refused_with_its_place(path: str, message: str) -> None:
    with pytest.raises(IecPathError, match=message) as caught:
        parse_path(path)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("WFLAGS", ResolvedPath(WORD, 8)),
        ("wFlags.3", ResolvedPath(BIT, 8, 3)),
        ("wFlags.11", ResolvedPath(BIT, 9, 3)),
        ("b1", ResolvedPath(BIT, 10, 1)),
        ("aGrid[-1,1]", ResolvedPath(INT, 12)),
        ("aGrid[0,2]", ResolvedPath(INT, 18)),
        ("aGrid[0][2]", ResolvedPath(INT, 18)),
        ("aaRow[6][1]", ResolvedPath(INT, 30)),
        ("aaRow[6,1]", ResolvedPath(INT, 30)),
        ("apoints[3].Y", ResolvedPath(LREAL, 72)),
        ("pPoint^.y", ResolvedPath(LREAL, 8, None, (80,))),
        ("rPoint.y", ResolvedPath(LREAL, 8, None, (88,))),
        ("rPoint^.y", ResolvedPath(LREAL, 8, None, (88,))),
        ("iAny", ResolvedPath(BLOCK.member("iAny").type, 96)),
    ],
)
def test_paths_lead_to_offsets(path: str, expected: ResolvedPath) -> None:
    assert locate(BLOCK, path) == expected


def test_a_row_of_an_array_is_an_array() -> None:
    row = locate(BLOCK, "aGrid[1]")
    assert (row.type.name, row.offset) == ("ARRAY [1..2] OF INT", 20)


def test_a_path_agrees_with_the_view() -> None:
    block = Block()
    block.aPoints[2].y = 4.5
    where = locate(BLOCK, "aPoints[2].y")
    assert where.type.read(bytearray(bytes(block)), where.offset) == 4.5


def test_methods_end_a_path() -> None:
    result = locate(BLOCK, "#reset")
    assert result.method is BLOCK.methods[0]
    with pytest.raises(IecPathError, match="nothing follows a method"):
        locate(BLOCK, "#Reset.x")


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("nope", "FB_Block has no member 'nope'"),
        ("x" * 10_000, "FB_Block has no member 'x{80}'"),
        ("wFlags.x", "WORD has no member 'x'"),
        ("wFlags.16", "WORD has no bit 16"),
        ("aPoints[1].x.3", "LREAL has no bit 3"),
        ("b0.0", "nothing follows a bit"),
        ("wFlags[0]", r"WORD is not an array: \[0\] leads nowhere"),
        ("aGrid[2,1]", r"index 2 is outside -1\.\.1 of ARRAY"),
        ("aGrid[0][3]", r"index 3 is outside 1\.\.2 of ARRAY"),
        ("aGrid[0,1,1]", "INT is not an array"),
        ("aPoints[99999999999]", r"index 99999999999 is outside 1\.\.3"),
        ("wFlags^", "WORD is not a pointer"),
        ("iAny^", "I_Any is not a pointer"),
        ("pPoint.x", "POINTER TO ST_Point has no member 'x'"),
        ("#Nope", "FB_Block has no method 'Nope'"),
        ("wFlags#Reset", "WORD has no method 'Reset'"),
    ],
    ids=range(16),
)
def test_what_leads_nowhere_is_refused(path: str, message: str) -> None:
    with pytest.raises(IecPathError, match=message):
        locate(BLOCK, path)


@given(st.text("aGrid[]pPoint^.x#Reset019,- ", max_size=30))
def test_any_text_leads_somewhere_or_is_refused(path: str) -> None:
    try:
        result = locate(BLOCK, path)
    except IecPathError:
        return
    if not result.hops:
        assert 0 <= result.offset <= BLOCK.size - result.type.size


def test_no_steps_lead_to_the_start() -> None:
    assert follow(BLOCK, ()) == ResolvedPath(BLOCK, 0)


SYMBOLS = {"main", "main.st", "main.a", "gvl.axis.pos", "constants.b"}


@pytest.mark.parametrize(
    ("path", "name", "rest"),
    [
        ("MAIN.st", "main.st", ""),
        (" MAIN.ST.x.Y ", "main.st", ".x.Y"),
        ("MAIN.a[3].b", "main.a", "[3].b"),
        ("MAIN.a^", "main.a", "^"),
        ("MAIN.other", "main", ".other"),
        ("MAIN#Run", "main", "#Run"),
        ("GVL.axis.pos.1", "gvl.axis.pos", ".1"),
    ],
)
def test_the_longest_symbol_is_found(path: str, name: str, rest: str) -> None:
    assert split_symbol(path, SYMBOLS) == (name, rest)


@pytest.mark.parametrize("path", ["", "x", "GVL.axis", "x" * 10_000, "a." * 5_000, "[1]"])
def test_no_symbol_is_no_symbol(path: str) -> None:
    with pytest.raises(IecPathError, match="no symbol is named") as caught:
        split_symbol(path, SYMBOLS)
    assert len(str(caught.value)) < 120


class Shared(FunctionBlock, name="FB_Shared"):
    nOwn = var(INT)
    stAll = Variable[Point, Point](iec_type(Point), section=Section.STATIC)


def test_a_static_variable_is_a_start_of_its_own() -> None:
    shared = iec_type(Shared)
    location = locate(ArrayType(shared, [Bounds(0, 3)]), "[2].stAll.y")
    assert location == ResolvedPath(LREAL, 8, None, (), None, shared.member("stAll"))


@pytest.mark.parametrize(
    "path", ["aGrid[2,1]", "aGrid[0,0]", "aPoints[4].x", "aaRow[5][99999999999999]"]
)
def test_an_index_out_of_bounds_is_distinguished(path: str) -> None:
    with pytest.raises(IecIndexError):
        locate(BLOCK, path)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (".a.b", ".a.b"),
        ("[ 003 , -01 ]", "[3,-1]"),
        ("^.x^", "^.x^"),
        (".n.07", ".n.7"),
        ("#Start", "#Start"),
    ],
)
def test_path_is_written_without_zeros_and_blanks(text: str, expected: str) -> None:
    assert format_path(parse_path(text)) == expected
