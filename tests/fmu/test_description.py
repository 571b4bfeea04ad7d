"""modelDescription.xml."""

import struct
from xml.etree import ElementTree

import pytest

from achse.fmu.description import Description, fitting, model_description
from achse.fmu.variables import DIGEST, TIME, UnitVariable, ValueType

ABOUT = Description("cell", "cell", "{token}", "0.1", 0.002, True)

LEVEL = UnitVariable(
    "MAIN.fLevel", "851:MAIN.fLevel", ValueType.FLOAT64, "input", 8, (), "mm/s2", "how\x01full"
)
COUNTS = UnitVariable("MAIN.aN", "851:MAIN.aN", ValueType.INT16, "parameter", 4, (2,))
TEXT = UnitVariable("MAIN.s", "851:MAIN.s", ValueType.STRING, "input", 9)
LONG = UnitVariable("MAIN.n", "851:MAIN.n", ValueType.INT64, "output", 8)
SPEED = UnitVariable("X.v", "500:X.v", ValueType.FLOAT64, "output", 8, (), "degree/s")
VARIABLES = [TIME, LEVEL, COUNTS, TEXT, LONG, SPEED, DIGEST]
STARTS = [
    bytes(8), struct.pack("<d", float("-inf")), struct.pack("<2h", -1, 2),
    b"\xc3\x96l".ljust(9, b"\0"), bytes(8), bytes(8), bytes(64),
]  # fmt: skip


def test_fmi_3_has_types_arrays_units_and_starts() -> None:
    root = ElementTree.fromstring(model_description(3, ABOUT, VARIABLES, STARTS))
    assert root.get("fmiVersion") == "3.0"
    assert root.get("instantiationToken") == "{token}"
    model = root.find("ModelVariables")
    assert model is not None
    assert [each.tag for each in model] == [
        "Float64", "Float64", "Int16", "String", "Int64", "Float64", "String",
    ]  # fmt: skip
    _, level, counts, text, *_ = model
    assert level.get("start") == "-INF"
    assert level.get("unit") == "mm/s2"
    assert level.get("description") == "how\ufffdfull"
    assert counts.get("start") == "-1 2"
    assert [each.get("start") for each in counts] == ["2"]
    assert [each.get("value") for each in text] == ["Öl"]
    acceleration = root.find("UnitDefinitions/Unit[@name='mm/s2']/BaseUnit")
    assert acceleration is not None
    assert acceleration.attrib == {"m": "1", "factor": "0.001", "s": "-2"}
    assert [each.get("valueReference") for each in root.iter("Output")] == ["4", "5"]


def test_fmi_2_has_scalar_variables() -> None:
    stored, left_out = fitting(2, [each for each in VARIABLES if not each.dimensions])
    assert left_out == [LONG]
    starts = [STARTS[VARIABLES.index(each)] for each in stored]
    root = ElementTree.fromstring(model_description(2, ABOUT, stored, starts))
    assert root.get("guid") == "{token}"
    scalars = list(root.iter("ScalarVariable"))
    assert [each.get("valueReference") for each in scalars] == ["1", "2", "3", "4"]
    assert [each[0].tag for each in scalars] == ["Real", "String", "Real", "String"]
    assert [each.get("index") for each in root.findall("ModelStructure/Outputs/Unknown")] == ["3"]


@pytest.mark.parametrize("has_states", [True, False])
def test_states_are_announced_where_they_work(has_states: bool) -> None:
    about = ABOUT._replace(has_states=has_states)
    root = ElementTree.fromstring(model_description(3, about, [TIME], [bytes(8)]))
    simulation = root.find("CoSimulation")
    assert simulation is not None
    flags = {simulation.get("canGetAndSetFMUState"), simulation.get("canSerializeFMUState")}
    assert flags == {str(has_states).lower()}


def test_every_type_fits_fmi_3() -> None:
    assert fitting(3, VARIABLES) == (VARIABLES, [])
