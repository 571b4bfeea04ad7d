"""Start values as one scope sees them, in a memory laid out by hand."""

import struct

import pytest

from achse.iec import DINT, INT, IecType, StructType
from achse.iec.layout import TC3_X64
from achse.iec.variables import PointedValue
from achse.st.declared.resolve import Resolver
from achse.st.declared.start_values import StartValues
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import Parser, parse
from achse.st.values.values import NotConstant

NAMES = Resolver({}, {}, TC3_X64)
NAMES.scopes.add(
    [
        parse(
            """
TYPE ST : STRUCT x : INT; y : DINT; END_STRUCT END_TYPE
VAR_GLOBAL
    n : INT; p : POINTER TO INT; pNull : POINTER TO INT; st : ST; a : ARRAY [1..3] OF INT;
    r : REFERENCE TO ST; c : BOOL;
END_VAR
VAR_GLOBAL CONSTANT cTwo : INT := 2; END_VAR
FUNCTION_BLOCK FB VAR own : INT; mine : DINT; END_VAR END_FUNCTION_BLOCK
"""
        ).check()
    ]
)


def type_named(name: str) -> IecType[object]:
    entry = NAMES.scopes.find(name)
    assert entry is not None
    return NAMES.entry_type(entry, 0)


class Laid:
    """The list from address 0x1000 on, with values."""

    def __init__(self) -> None:
        entry = NAMES.scopes.find("<text>") or NAMES.scopes.find("GVL")
        assert entry is not None
        self.list = entry.name
        point = type_named("ST")
        scope = NAMES.scopes.scope(entry)
        self.spots: dict[str, PointedValue] = {}
        self.memory: dict[int, bytes] = {}
        address = 0x1000
        values = {
            "n": struct.pack("<h", -7),
            "p": struct.pack("<Q", 0x1000),
            "pnull": bytes(8),
            "st": struct.pack("<hxxi", 5, 70000),
            "a": struct.pack("<3h", 11, 12, 13),
            "c": b"\x20",
        }
        values["r"] = struct.pack("<Q", 0x1000 + 0x10 * list(scope.variables).index("st"))
        for name in scope.variables:
            _, tree = scope.variables[name]
            bit = 5 if name == "c" else None
            self.spots[name] = PointedValue(NAMES.type_of(tree.type, scope, name), address, bit)
            self.memory[address] = values.get(name, bytes(8))
            address += 0x10
        self.memory[0x2000] = bytes(8) + struct.pack("<hxxi", 21, 22)
        assert isinstance(point, StructType)

    def variable(self, name: str) -> PointedValue:
        return self.spots[name.rpartition(".")[2].lower()]

    def read(self, address: int, size: int) -> bytes:
        for start, content in self.memory.items():
            if start <= address and address + size <= start + len(content):
                return content[address - start : address - start + size]
        raise LookupError(address)


LAID = Laid()
OWN = PointedValue(type_named("FB"), 0x2000)


def values(block: bool = False) -> StartValues:
    entry = NAMES.scopes.find("FB" if block else LAID.list)
    assert entry is not None
    return StartValues(NAMES, NAMES.scopes.scope(entry), LAID, OWN)


def encoded(text: str, type: IecType[object], *, block: bool = False) -> bytes:
    tree = Parser(Source(text)).expressions.expression()
    return values(block).encoded(type, tree)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("n", -7),
        ("n + 1", -6),
        ("-n * cTwo", 14),
        ("p^", -7),
        ("st.x", 5),
        ("r.x", 5),
        ("r.y - 70000", 0),
        ("a[3]", 13),
        ("a[cTwo]", 12),
        ("SEL(c, 1, 2)", 2),
        ("SEL(n > 0, 1, 2)", 1),
    ],
)
def test_values_of_variables(text: str, value: int) -> None:
    assert encoded(text, INT) == struct.pack("<h", value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "name", "distance"),
    [
        ("ADR(n)", "n", 0),
        ("ADR(p^)", "n", 0),
        ("ADR(st.y)", "st", 4),
        ("ADR(a[2])", "a", 2),
        ("ADR(r)", "st", 0),
        ("ADR(r.y)", "st", 4),
        ("p", "n", 0),
        ("ADR(a) + 4", "a", 4),
    ],
)
def test_addresses_of_variables(text: str, name: str, distance: int) -> None:
    pointer = LAID.variable("p").type
    assert encoded(text, pointer) == struct.pack("<Q", LAID.variable(name).address + distance)


def test_a_reference_is_bound_to_what_another_leads_to() -> None:
    reference = LAID.variable("r").type
    tree = Parser(Source("r")).expressions.expression()
    assert values().address(reference, tree) == struct.pack("<Q", LAID.variable("st").address)


def test_a_whole_structure_is_copied() -> None:
    assert encoded("st", type_named("ST")) == struct.pack("<hxxi", 5, 70000)
    with pytest.raises(Unexpected, match="ST takes no ARRAY"):
        encoded("a", type_named("ST"))


def test_a_block_sees_its_own_variables_first() -> None:
    assert encoded("own", INT, block=True) == struct.pack("<h", 21)  # type: ignore[arg-type]
    assert encoded("THIS^.mine + n", DINT, block=True) == struct.pack("<i", 15)  # type: ignore[arg-type]
    pointer = LAID.variable("p").type
    assert encoded("THIS", pointer, block=True) == struct.pack("<Q", 0x2000)


def test_calls_take_a_running_program() -> None:
    with pytest.raises(NotConstant):
        encoded("Calculate(1)", INT)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("pNull^", "POINTER TO INT has no target yet"),
        ("n^", "INT is not a pointer"),
        ("a[4]", "index 4 is outside 1..3"),
        ("n.x", "INT has no member 'x'"),
    ],
)
def test_missing_target_is_reported(text: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        encoded(text, INT)  # type: ignore[arg-type]
