"""Programs and variable lists in memory: places, initial values, partners."""
# ruff: noqa: N815 (IEC names)

import pytest

from achse.iec import (
    ARRAY,
    BIT,
    BOOL,
    DINT,
    INT,
    LREAL,
    UDINT,
    UINT,
    DeclarationError,
    FunctionBlock,
    GlobalVariables,
    Program,
    Struct,
    var,
)
from achse.iec.structs import StaticRecord
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedUnit, place


def started(*declared: type[StaticRecord], memory: Memory | None = None) -> list[PlacedUnit]:
    memory = memory or Memory()
    units = place(declared, memory)
    memory.hold_initial()
    partners: dict[object, object] = {}
    for unit in units:
        partners[type(unit.instance)] = partners[unit.name] = unit.instance
    for unit in units:
        unit.start(partners)
    return units


def places(unit: PlacedUnit) -> dict[str, tuple[Area, int, int | None]]:
    return {one.name: (one.area, one.offset, one.bit) for one in unit.variables}


class Mixed(Program, name="MAIN"):
    bFlag = var(BOOL, True)
    fValue = var(LREAL, 1.5)
    nFlags = var(UINT, 0x1234, at="%MW4")
    bInput = var(BOOL, at="%IX1.2")
    bSet = var(BOOL, True, at="%QX0.7")
    nFree = var(UDINT, 7, at="%Q*")
    nRetain = var(DINT, -5, retain=True)
    nLast = var(UDINT, 9)


def test_each_variable_lies_where_its_declaration_says() -> None:
    (unit,) = started(Mixed)
    assert places(unit) == {
        "MAIN.bFlag": (Area.DATA, 0, None),
        "MAIN.fValue": (Area.DATA, 8, None),
        "MAIN.nFlags": (Area.FLAG, 4, None),
        "MAIN.bInput": (Area.INPUT, 1, 2),
        "MAIN.bSet": (Area.OUTPUT, 0, 7),
        "MAIN.nFree": (Area.OUTPUT, 4, None),  # aligned, behind the fixed byte 0
        "MAIN.nRetain": (Area.RETAIN, 0, None),
        "MAIN.nLast": (Area.DATA, 16, None),
    }


def test_initial_values_are_in_the_memory() -> None:
    memory = Memory()
    started(Mixed, memory=memory)
    assert memory[Area.FLAG].read(4, 2) == b"\x34\x12"
    assert memory[Area.OUTPUT].read(0, 8) == b"\x80\0\0\0\x07\0\0\0"
    assert memory[Area.RETAIN].read(0, 8) == b"\xfb\xff\xff\xff\0\0\0\0"
    assert memory[Area.DATA].read(0, 1) == b"\x01"
    assert memory[Area.DATA].read(16, 4) == b"\x09\0\0\0"


def test_a_program_reads_and_writes_the_memory_in_place() -> None:
    memory = Memory()
    (unit,) = started(Mixed, memory=memory)
    program = unit.instance
    assert isinstance(program, Mixed)
    memory[Area.INPUT].write_bits(10, b"\x01")
    assert program.bInput
    program.bSet = False
    assert memory[Area.OUTPUT].read(0, 1) == b"\0"
    program.nRetain = 77
    program.nFlags = 2
    assert memory[Area.RETAIN].read(0, 1) == b"\x4d"
    assert memory[Area.FLAG].read(4, 2) == b"\x02\0"


def test_fixed_addresses_share_memory_and_free_ones_keep_clear_of_all_of_them() -> None:
    class First(GlobalVariables):
        nFree = var(UDINT, at="%M*")
        nWord = var(UDINT, at="%MD0")

    class Second(GlobalVariables):
        nLow = var(UINT, 0x0102, at="%MW0")
        nHigh = var(UINT, at="%MW100")

    first, second = started(First, Second)
    assert places(first)["First.nFree"] == (Area.FLAG, 104, None)
    assert isinstance(first.instance, First)
    assert first.instance.nWord == 0x0102
    assert second.instance["nHigh"] == 0


def test_a_cold_reset_spares_retain_and_persistent_variables_at_any_depth() -> None:
    class Counter(FunctionBlock):
        nTotal = var(UDINT, 1, persistent=True)
        nNow = var(UDINT, 2)

    class Lists(GlobalVariables):
        nKept = var(DINT, 3, persistent=True)
        nPlain = var(DINT, 4)
        nRetain = var(DINT, 5, retain=True)
        fbs = var(ARRAY(Counter, (1, 2)))

    memory = Memory()
    (unit,) = started(Lists, memory=memory)
    lists = unit.instance
    assert isinstance(lists, Lists)

    def values() -> list[int]:
        fb = lists.fbs[2]
        return [lists.nKept, lists.nPlain, lists.nRetain, fb.nTotal, fb.nNow]

    lists.nKept = lists.nPlain = lists.nRetain = 100
    lists.fbs[2].nTotal = lists.fbs[2].nNow = 100
    memory.reset()
    assert values() == [100, 4, 100, 100, 2]
    memory.reset(origin=True)
    assert values() == [3, 4, 5, 1, 2]


def test_annotations_of_a_class_name_its_partners() -> None:
    class GVL(GlobalVariables):
        nCount = var(INT, 3)

    class User(Program):
        gvl: GVL
        text: "SomethingElse"  # type: ignore[name-defined]  # noqa: F821
        note: int
        history: "dict[str, list[int]] | None"
        quoted: "GVL"

        def cycle(self) -> None:
            self.gvl.nCount += 1

    _, unit = started(GVL, User)
    user = unit.instance
    assert isinstance(user, User)
    user.cycle()
    assert user.gvl.nCount == 4
    assert user.quoted is user.gvl
    assert not hasattr(user, "text")


def test_a_partner_that_is_not_declared_is_an_error() -> None:
    class GVL(GlobalVariables):
        nCount = var(INT)

    class User(Program):
        gvl: GVL

    with pytest.raises(DeclarationError, match=r"User\.gvl: GVL is not declared"):
        started(User)


def test_a_start_forgets_python_attributes_and_runs_init_again() -> None:
    class Prog(Program):
        nStarts = var(INT)

        def __init__(self) -> None:
            self.seen: list[int] = []
            self.nStarts += 1

    (unit,) = started(Prog)
    prog = unit.instance
    assert isinstance(prog, Prog)
    prog.seen.append(1)
    unit.start({})
    assert prog.seen == []
    assert prog.nStarts == 2


def test_structures_and_bits_inside_a_unit_have_places() -> None:
    class Inner(Struct):
        a = var(INT, 1)
        b = var(INT, 2)

    class Lists(GlobalVariables):
        b0 = var(BIT)
        b1 = var(BIT, True)
        inner = var(Inner)

    (unit,) = started(Lists)
    assert places(unit) == {
        "Lists.b0": (Area.DATA, 0, 0),
        "Lists.b1": (Area.DATA, 0, 1),
        "Lists.inner": (Area.DATA, 2, None),
    }
    assert isinstance(unit.instance, Lists)
    assert unit.instance.b1
    assert unit.instance.inner.b == 2


def test_a_variable_outside_its_area_is_an_error_with_its_name() -> None:
    class Far(GlobalVariables):
        nFar = var(UDINT, at="%MD65533")

    with pytest.raises(DeclarationError, match=r"Far\.nFar AT %MD65533: %M has 65536 bytes"):
        started(Far)

    class Big(GlobalVariables):
        aBig = var(ARRAY(UDINT, (1, 20_000)), at="%I*")

    with pytest.raises(DeclarationError, match=r"Big\.aBig AT %I\*"):
        started(Big)


def test_a_bit_address_takes_a_bool_only() -> None:
    class Wrong(GlobalVariables):
        nWrong = var(INT, at="%MX0.1")

    with pytest.raises(DeclarationError, match="takes BOOL, got INT"):
        started(Wrong)


def test_two_units_of_one_name_are_an_error() -> None:
    class Gvl(GlobalVariables):
        a = var(INT)

    class Other(GlobalVariables, name="GVL"):
        b = var(INT)

    with pytest.raises(DeclarationError, match="GVL is declared twice"):
        started(Gvl, Other)
