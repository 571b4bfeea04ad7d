"""Python classes bound by name to declared programs and function blocks."""
# ruff: noqa: N801, N815 (IEC names)

from datetime import timedelta
from typing import Any

import pytest

from achse.iec import INT, LREAL, DeclarationError, GlobalVariables, Method, Program, Variable
from achse.iec.structs import RecordKind, RecordMeta, StructType
from achse.plc import PlcRuntime, Task
from achse.plc.behaviour import with_behaviour
from achse.plc.bodies import Bodies
from achse.st.check import check
from achse.st.declare import declare
from achse.st.syntax.parser import parse


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


SOURCES = """
TYPE ST_Recipe : STRUCT nId : INT := 7; sName : STRING(20) := 'none'; END_STRUCT END_TYPE
VAR_GLOBAL fLoad : LREAL := 12.5; stActive : ST_Recipe := (nId := 1); END_VAR
FUNCTION_BLOCK FB_Scale
VAR_OUTPUT fWeight : LREAL; END_VAR
METHOD Weigh : BOOL
VAR_INPUT sName : STRING; tWait : TIME; stIn : ST_Recipe; END_VAR
VAR_OUTPUT fMean : LREAL; stUsed : ST_Recipe; END_VAR
END_METHOD
METHOD Current : ST_Recipe END_METHOD
METHOD Nothing : STRING END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    fbScale : FB_Scale; bDone : BOOL; fMean : LREAL; stUsed, stNow : ST_Recipe; s : STRING := 'a';
END_VAR
fbScale();
bDone := fbScale.Weigh('x', T#2S, stNow, fMean => fMean, stUsed => stUsed);
stNow := fbScale.Current();
s := fbScale.Nothing();
END_PROGRAM
"""


class FB_Scale:
    plant: "GVL"  # type: ignore[name-defined]  # noqa: F821
    fWeight: float

    def cycle(self) -> None:
        self.fWeight = self.plant.fLoad
        self.plant.stActive = {}

    def Weigh(self, name: str, wait: timedelta, record: Any) -> Any:  # noqa: N802
        return True, wait.total_seconds(), {"nId": record.nId + 1, "sName": name}

    def Current(self) -> Any:  # noqa: N802
        return self.plant.stActive

    def Nothing(self) -> None:  # noqa: N802
        return None


def test_python_blocks_reach_lists_and_give_structures() -> None:
    """Values that Structured Text hands over and gets are Python's; `{}` clears a structure."""
    project = declare([parse(SOURCES)])
    units = with_behaviour(project.units, [FB_Scale], project.types.values())
    main = next(unit for unit in units if issubclass(unit, Program))
    rest = [unit for unit in units if unit is not main]
    plc = PlcRuntime([Task("T", 1_000_000, [main])], rest, bodies=Bodies(check(project)))
    plc.run_due(1_000_000)
    assert plc.failure == ""
    unit: Any = plc.instance("MAIN")
    assert (unit["fbScale"].fWeight, unit["bDone"], unit["fMean"], unit["s"]) == (
        12.5,
        True,
        2.0,
        "",
    )
    assert (unit["stUsed"].nId, unit["stUsed"].sName) == (8, "x")
    assert (unit["stNow"].nId, plc.instance("GVL")["stActive"].nId) == (7, 7)
