"""Python classes bound by name to declared programs and function blocks."""
# ruff: noqa: N801, N815 (IEC names)

from typing import Any

import pytest

from achse.iec import INT, LREAL, DeclarationError, GlobalVariables, Method, Program, Variable
from achse.iec.structs import RecordKind, RecordMeta, StructType
from achse.plc import PlcRuntime, Task
from achse.plc.behaviour import with_behaviour


def _block(name: str, base: StructType[Any] | None = None) -> StructType[Any]:
    members: list[Variable[Any, Any]] = (
        [Variable(INT, name="nCalls")] if base is None else [Variable(LREAL, name="fMore")]
    )
    return StructType(
        name, members, kind=RecordKind.FUNCTION_BLOCK, base=base, methods=[Method("Add")]
    )


def _units() -> list[Any]:
    base = _block("FB_Base")
    iec: StructType[Any] = StructType(
        "MAIN",
        [
            Variable(INT, 5, name="nCounter"),
            Variable(base, name="fbOne"),
            Variable(_block("FB_More", base), name="fbTwo"),
        ],
        kind=RecordKind.UNIT,
    )
    namespace = {item.name: item for item in iec.members}
    main = RecordMeta("MAIN", (Program,), namespace, iec=iec)
    gvl: StructType[Any] = StructType("GVL", [Variable(INT, name="nLimit")], kind=RecordKind.UNIT)
    return [
        main,
        RecordMeta("GVL", (GlobalVariables,), {i.name: i for i in gvl.members}, iec=gvl),
    ]


class Main:
    binds = "main"
    gvl: "GVL"  # type: ignore[name-defined]  # noqa: F821
    nCounter: int
    fbOne: Any
    fbTwo: Any

    def __init__(self) -> None:
        self.cycles = 0

    def cycle(self) -> None:
        self.cycles += 1
        self.nCounter += 1
        self.gvl.nLimit = self.nCounter
        self.fbOne.add()
        self.fbTwo.add()


class FB_Base:
    nCalls: int

    def add(self) -> None:
        self.nCalls += 1


class FB_More:
    fMore: float

    def add(self) -> None:
        super().add()  # type: ignore[misc]
        self.fMore += 0.5


def test_a_program_and_its_blocks_run_their_python_classes() -> None:
    units = with_behaviour(_units(), [FB_More, Main, FB_Base])
    program = units[0]
    assert issubclass(program, Program)
    plc = PlcRuntime([Task("T", 1_000_000, [program])], units[1:])
    plc.run_due(3_000_000)
    assert plc.failure == ""
    main: Any = plc.instance("Main")
    assert (main.nCounter, main.cycles, plc.instance("gvl")["nLimit"]) == (8, 3, 8)
    assert (main.fbOne.nCalls, main.fbTwo.nCalls, main.fbTwo.fMore) == (3, 3, 1.5)
    assert isinstance(main, Main)
    assert isinstance(main.fbTwo, FB_Base)


class FB_Bse:
    pass


def test_a_behaviour_of_nothing_names_what_is_near() -> None:
    with pytest.raises(
        DeclarationError, match=r"FB_Bse: no program.*named 'FB_Bse'; near: fb_base"
    ):
        with_behaviour(_units(), [FB_Bse])


def test_two_behaviours_of_the_same_are_refused() -> None:
    with pytest.raises(DeclarationError, match="MAIN has two behaviours"):
        with_behaviour(_units(), [Main, type("MAIN", (), {})])


class Declared(Program):
    pass


def test_without_behaviours_the_units_are_the_same() -> None:
    assert with_behaviour([Declared], []) == [Declared]
