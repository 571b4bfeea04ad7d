"""modelDescription.xml of strangers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.plants.description import PlantVariable, read_description
from achse.station.plants.errors import PlantError
from tests.station.plant_units import VARIABLES, description

BOMB = (
    '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {chr(98 + n)} "{f"&{chr(97 + n)};" * 10}">' for n in range(9))
    + ']><fmiModelDescription fmiVersion="3.0" modelName="&j;"/>'
)
OUTSIDE = (
    '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
    '<fmiModelDescription fmiVersion="3.0" modelName="&a;"/>'
)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", VARIABLES)
def test_variables_are_read(name: str, fmi: int) -> None:
    unit = read_description(description(name, fmi).encode())
    assert (unit.fmi, unit.token, unit.identifier) == (fmi, f"{{{name}}}", name)
    assert [(each.name, each.causality) for each in unit.variables.values()] == [
        (variable, causality) for variable, _, causality in VARIABLES[name]
    ]
    assert [each.reference for each in unit.variables.values()] == list(range(len(unit.variables)))


@pytest.mark.parametrize("coding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("text", [BOMB, OUTSIDE], ids=["bomb", "outside"])
def test_document_types_are_refused(text: str, coding: str) -> None:
    with pytest.raises(PlantError, match="expected no document type declaration"):
        read_description(text.encode(coding))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "no element found"),
        ("<a><b></a>", "expected FMI 2.0 or 3.0, got a"),
        ("<fmiModelDescription/>", "expected FMI 2.0 or 3.0"),
        ('<fmiModelDescription fmiVersion="1.0"/>', "got fmiModelDescription '1.0'"),
        ('<fmiModelDescription fmiVersion="3.0"/>', "expected a unit for co-simulation"),
        (
            '<fmiModelDescription fmiVersion="3.0"><CoSimulation modelIdentifier="../x"/>'
            "</fmiModelDescription>",
            r"identifier, got '\.\./x'",
        ),
        ('<fmiModelDescription fmiVersion="3.0">' + "<a>" * 200, "deeper than 100"),
        (
            '<fmiModelDescription fmiVersion="3.0"><ModelVariables><Float64 name="x"'
            ' valueReference="-1"/></ModelVariables></fmiModelDescription>',
            "'x': expected a value reference, got '-1'",
        ),
    ],
)
def test_wrong_descriptions_are_refused(text: str, complaint: str) -> None:
    with pytest.raises(PlantError, match=complaint):
        read_description(text.encode())


@given(st.binary(max_size=300))
def test_any_bytes_raise_only_the_plant_error(data: bytes) -> None:
    with pytest.raises(PlantError):
        read_description(data)


def test_only_numbers_can_be_linked() -> None:
    text = description("tank", 3).replace(
        "<ModelVariables>",
        '<ModelVariables><Float64 name="a" valueReference="9"><Dimension start="3"/></Float64>'
        '<String name="s" valueReference="8"/>',
    )
    unit = read_description(text.encode())
    assert unit.number("level") == PlantVariable("level", 2, "Float64", "output")
    for name, complaint in (
        ("a", "expected a number or a Boolean, got an array of Float64"),
        ("s", "expected a number or a Boolean, got String"),
        ("levle", "expected a variable of the unit, got 'levle'; did you mean 'level'"),
    ):
        with pytest.raises(PlantError, match=complaint):
            unit.number(name)
    with pytest.raises(PlantError, match="level: expected input or parameter, got output"):
        unit.number("level", "input", "parameter")
