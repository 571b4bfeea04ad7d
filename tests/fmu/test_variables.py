"""Choosing the variables of a unit."""

from pathlib import Path

import pytest

from achse.fmu.errors import ExportError
from achse.fmu.variables import (
    DIGEST,
    TIME,
    UnitVariable,
    ValueType,
    VariableChoice,
    chosen_variables,
    find_symbol,
    value_type,
)
from achse.iec.elementary import BOOL, DINT, LREAL, LWORD, REAL, SINT, UINT
from achse.iec.strings import StringType, WStringType
from achse.iec.times import LTIME
from achse.iec.times import TIME as TIME_TYPE
from achse.station import Station


@pytest.fixture
def station(station_file: Path) -> Station:
    return Station.load(station_file)


def by_name(variables: list[UnitVariable]) -> dict[str, UnitVariable]:
    return {each.name: each for each in variables}


def test_process_image_and_axes_are_variables(station: Station) -> None:
    result = by_name(chosen_variables(station, VariableChoice()))
    assert [name for name, each in result.items() if each.causality == "input"] == [
        "MAIN.aIn", "MAIN.bGo", "MAIN.fLevel", "MAIN.nSpeed",
    ]  # fmt: skip
    assert result["MAIN.aIn"].dimensions == (3,)
    assert result["MAIN.bOut"].causality == result["Axes.X.ActPos"].causality == "output"
    assert result["Axes.X.SetVelo"].unit == "mm/s"
    assert result["Axes.X.SetPos"].description == "set position"
    assert next(iter(result)) == TIME.name
    assert list(result)[-1] == DIGEST.name


def test_symbols_are_chosen_by_name_and_pattern(station: Station) -> None:
    choice = VariableChoice(
        parameters=["main.fgain"],
        outputs=["MAIN.stPart.aSizes[1]"],
        locals=["MAIN.*", "500:Axes.X.PosDiffCouple"],
        process_image=False,
        axes=False,
    )
    result = by_name(chosen_variables(station, choice))
    assert result["MAIN.fGain"].causality == "parameter"
    assert result["MAIN.stPart.aSizes[1]"].type is ValueType.UINT32
    assert result["MAIN.stPart.aSizes"].dimensions == (3,)
    assert result["MAIN.stPart.sName"].type is ValueType.STRING
    assert result["MAIN.nCount"].description.strip() == "cycles so far"
    assert result["MAIN.tWait"] == UnitVariable(
        "MAIN.tWait", "851:MAIN.tWait", ValueType.UINT32, "local", 4, (), "ms"
    )
    assert result["Axes.X.PosDiffCouple"].causality == "local"


def test_arrays_are_elements_where_only_scalars_may_be(station: Station) -> None:
    result = by_name(chosen_variables(station, VariableChoice(locals=["MAIN.st*"]), scalars=True))
    assert [name for name in result if "aIn" in name] == [f"MAIN.aIn[{n}]" for n in (1, 2, 3)]
    assert "MAIN.stPart.aSizes[0]" in result
    assert all(each.dimensions == () for each in result.values())


@pytest.mark.parametrize(
    ("choice", "complaint"),
    [
        (VariableChoice(locals=["MAIN.nCuont"]), r"expected a symbol of the station.*MAIN\.nCount"),
        (VariableChoice(locals=["MAIN.x*"]), "MAIN.x.: expected a symbol"),
        (VariableChoice(inputs=["MAIN.cLimit"]), "cLimit: expected a variable that can be written"),
        (
            VariableChoice(inputs=["Axes.X.ActPos"]),
            "ActPos: expected a variable that can be written",
        ),
        (VariableChoice(locals=["852:MAIN.nCount"]), "one of the ports 851, 500, got 852"),
    ],
)
def test_wrong_choice_is_refused(station: Station, choice: VariableChoice, complaint: str) -> None:
    with pytest.raises(ExportError, match=complaint):
        chosen_variables(station, choice)


def test_bytes_that_a_terminal_writes_are_no_inputs(station_file: Path) -> None:
    with station_file.open("a") as file:
        file.write('[[bus]]\n[[terminal]]\nname = "T"\ninput_address = 2\noutput_address = 0\n')
    result = by_name(chosen_variables(Station.load(station_file), VariableChoice()))
    assert result["MAIN.nSpeed"].causality == "output"
    assert result["MAIN.bGo"].causality == "input"


def test_variables_that_a_signal_writes_are_no_inputs(station_file: Path) -> None:
    with station_file.open("a") as file:
        file.write('[[signal]]\nsymbol = "MAIN.fLevel"\nkind = "noise"\n')
    result = by_name(chosen_variables(Station.load(station_file), VariableChoice()))
    assert result["MAIN.fLevel"].causality == "output"


def test_variables_linked_to_an_axis_are_left_out(station_file: Path) -> None:
    text = station_file.read_text().replace(
        'name = "X"', 'name = "X"\nplc = ["MAIN.fromNc", "MAIN.toNc"]'
    )
    station_file.write_text(text)
    program = station_file.parent / "cell.st"
    declared = "VAR fromNc AT %I* : NCTOPLC_AXLESTRUCT; toNc AT %Q* : PLCTONC_AXLESTRUCT; END_VAR"
    program.write_text(program.read_text().replace("PROGRAM MAIN", f"PROGRAM MAIN {declared}"))
    result = by_name(chosen_variables(Station.load(station_file), VariableChoice()))
    assert not [name for name in result if "fromNc" in name or "toNc" in name]


def test_names_that_are_no_identifiers_are_quoted(station_file: Path) -> None:
    station_file.write_text(station_file.read_text().replace('"X"', '"Axis 1"'))
    result = by_name(chosen_variables(Station.load(station_file), VariableChoice()))
    assert "Axes.'Axis 1'.ActPos" in result


def test_types_are_those_of_the_same_width() -> None:
    assert [value_type(each) for each in (BOOL, SINT, UINT, DINT, LWORD, REAL, LREAL)] == [
        ValueType.BOOLEAN, ValueType.INT8, ValueType.UINT16, ValueType.INT32, ValueType.UINT64,
        ValueType.FLOAT32, ValueType.FLOAT64,
    ]  # fmt: skip
    assert value_type(TIME_TYPE) is ValueType.UINT32
    assert value_type(LTIME) is ValueType.UINT64
    assert value_type(StringType(5)) is ValueType.STRING
    assert value_type(WStringType(5)) is None


def test_variable_survives_its_document(station: Station) -> None:
    for each in chosen_variables(station, VariableChoice(locals=["MAIN.*"])):
        assert UnitVariable.of(each.document()) == each


def test_unknown_symbol_is_named(station: Station) -> None:
    with pytest.raises(ExportError, match=r"851:MAIN\.nothing: expected a symbol"):
        find_symbol(station, "851:MAIN.nothing")
