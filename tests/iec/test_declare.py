"""Programs and variable lists declared in typed Python."""

# ruff: noqa: N815  (variables carry the prefixes of IEC programs)

from datetime import timedelta
from typing import assert_type

import pytest

from achse.iec.arrays import Array
from achse.iec.declare import (
    ARRAY,
    GlobalVariables,
    Program,
    iec_type,
    method,
    pointer_to,
    reference_to,
    var,
    var_input,
    var_output,
    variables,
)
from achse.iec.elementary import BOOL, DINT, INT, LREAL, UDINT
from achse.iec.enums import Enumeration
from achse.iec.errors import DeclarationError, IecValueError, UnboundError
from achse.iec.structs import FunctionBlock, RecordKind, Struct, bind
from achse.iec.times import TIME
from achse.iec.variables import Address, Place, Section


class State(Enumeration):
    Idle = 0
    Run = 1


class Axis(Struct, name="ST_Axis"):
    fPos = var(LREAL)


class Adder(FunctionBlock, name="FB_Adder"):
    nIn = var_input(INT)
    nOut = var_output(INT)

    @method(LREAL, outputs={"nRest": DINT}, fValue=LREAL, comment="halves")
    def halve(self, value: float) -> tuple[float, int]:
        return value / 2, int(value) % 2


class MAIN(Program):
    nCounter = var(UDINT, 7)
    bOut = var(BOOL, at="%QX3.2")
    stAxis = var(Axis, comment="the axis", attributes={"TcLinkTo": "x"})
    stKept = var(Axis, retain=True)
    aValues = var(ARRAY(INT, (1, 10)))
    aAxes = var(ARRAY(Axis, (1, 2)))
    eState = var(State)
    tRun = var(TIME, persistent=True)
    fbAdder = var(Adder)
    from_ = var(INT, name="from")

    def cycle(self) -> None:
        self.nCounter += 1
        self.stAxis.fPos = 1.5
        self.aValues[3] = 5
        self.aAxes[2].fPos += 2.5
        self.eState = State.Run
        self.tRun += timedelta(milliseconds=10)
        self.bOut = not self.bOut


class GVL(GlobalVariables, name="GVL_Test"):
    nGlobal = var(INT, 3)


def test_a_program_works_in_the_memory_it_is_bound_to() -> None:
    main = MAIN()
    memory = bytearray(1000)
    outputs = bytearray(8)
    retained = bytearray(16)
    size = iec_type(MAIN).size
    memory[100 : 100 + size] = iec_type(MAIN).default
    places = {"bOut": Place(outputs, 3, 2), "stKept": Place(retained, 8)}
    bind(main, memory, 100, places)
    main.cycle()
    main.stKept.fPos = 4.0
    assert main.nCounter == 8
    assert memory[100:104] == b"\x08\0\0\0"
    assert outputs == b"\0\0\0\x04\0\0\0\0"
    assert retained == bytes(8) + LREAL.encode(4.0)
    assert main.aValues == [0, 0, 5, 0, 0, 0, 0, 0, 0, 0]
    assert main.tRun == timedelta(milliseconds=10)
    main.cycle()
    assert outputs[3] == 0
    assert main.aAxes[2].fPos == 5.0


def test_without_memory_a_program_says_so() -> None:
    main = MAIN()
    with pytest.raises(UnboundError, match=r"MAIN.nCounter has no memory yet: bind the record"):
        main.cycle()
    with pytest.raises(UnboundError, match=r"MAIN\.nCounter"):
        main.nCounter = 1
    assert repr(main) == "<unbound MAIN>"
    bind(main, bytearray(1000))
    with pytest.raises(UnboundError, match=r"MAIN\.bOut"):
        main.bOut = True


def test_alone_a_program_starts_as_declared() -> None:
    main = MAIN()
    bind(main)
    main.cycle()
    assert (main.nCounter, main.bOut, main.eState) == (8, True, State.Run)
    assert (main.from_, main["from"]) == (0, 0)


def test_a_refused_value_changes_nothing() -> None:
    main = MAIN()
    bind(main)
    with pytest.raises(IecValueError, match=r"UDINT takes an integer in 0..4294967295, got -1"):
        main.nCounter = -1
    with pytest.raises(IecValueError, match="UDINT takes"):
        main.nCounter = 1.5  # type: ignore[assignment]
    assert main.nCounter == 7


def test_variables_report_what_was_declared() -> None:
    results = {item.name: item for item in variables(MAIN)}
    assert list(results)[:3] == ["nCounter", "bOut", "stAxis"]
    assert "from" in results
    assert results["nCounter"].initial_bytes() == b"\7\0\0\0"
    assert results["bOut"].address == Address("Q", "X", 3, 2)
    assert results["bOut"].apart
    assert results["stKept"].apart
    assert results["tRun"].persistent
    assert not results["tRun"].apart
    assert results["stAxis"].comment == "the axis"
    assert results["stAxis"].attributes == {"TcLinkTo": "x"}
    assert [item.section for item in variables(Adder)] == [Section.INPUT, Section.OUTPUT]
    assert variables(MAIN()) == variables(MAIN)


def test_only_what_lies_together_is_laid_out() -> None:
    offsets = {item.name: item.offset for item in iec_type(MAIN).fields}
    assert "bOut" not in offsets
    assert (offsets["nCounter"], offsets["stAxis"], offsets["aValues"]) == (0, 8, 16)


def test_lists_have_a_name_of_their_own() -> None:
    gvl = GVL()
    bind(gvl)
    assert gvl.nGlobal == 3
    assert iec_type(GVL).name == "GVL_Test"
    assert MAIN.__iec__.kind is RecordKind.UNIT


def test_methods_are_part_of_the_type() -> None:
    halve = Adder.__iec__.method("HALVE")
    assert [item.name for item in halve.inputs] == ["fValue"]
    assert [item.name for item in halve.outputs] == ["nRest"]
    assert (halve.returns, halve.comment) == (LREAL, "halves")
    values = Adder().halve(*halve.decode_inputs(halve.encode_inputs({"fValue": 5.0})))
    assert halve.decode_answer(halve.encode_answer(values)) == (2.5, 1)


def test_types_are_named_by_objects_and_classes() -> None:
    assert iec_type(INT) is INT
    assert iec_type(Axis) is iec_type(Axis()) is Axis.__iec__
    assert iec_type(State).name == "State"
    assert pointer_to(Axis).name == "POINTER TO ST_Axis"
    assert reference_to(State, 4).size == 4
    assert ARRAY(ARRAY(Axis, (0, 1)), (1, 2)).name == "ARRAY [1..2] OF ARRAY [0..1] OF ST_Axis"
    with pytest.raises(DeclarationError, match="an IEC type or a class declared as one"):
        iec_type(int)  # type: ignore[type-var]
    with pytest.raises(DeclarationError, match=r"array bounds 2..1 run backwards"):
        ARRAY(INT, (2, 1))


def test_type_checkers_see_the_values() -> None:
    main = MAIN()
    bind(main)
    assert_type(main.nCounter, int)
    assert_type(main.bOut, bool)
    assert_type(main.stAxis, Axis)
    assert_type(main.stAxis.fPos, float)
    assert_type(main.aValues, Array[int])
    assert_type(main.aAxes[1].fPos, float)
    assert_type(main.eState, State | int)
    assert_type(main.tRun, timedelta)
    assert_type(main.fbAdder.nIn, int)
