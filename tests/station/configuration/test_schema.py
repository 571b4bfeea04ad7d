"""The schema for editors: complete, and of the same mind as the loader."""

import math
from pathlib import Path
from typing import Any

import pytest

from achse.faults.kinds import STATION_FAULTS
from achse.motion.nc import configurable
from achse.station import ConfigError, StationConfig
from achse.station.configuration.documents import parse_toml
from achse.station.configuration.schema import descriptions_of, station_schema
from achse.station.configuration.station_file import axis_keys, parse

SCHEMA = station_schema()
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def is_valid() -> Any:
    validators = pytest.importorskip("jsonschema")
    validators.Draft7Validator.check_schema(SCHEMA)
    validator = validators.Draft7Validator(SCHEMA)
    return lambda document: not list(validator.iter_errors(document))


def _loads(document: dict[str, Any]) -> bool:
    try:
        parse(document, "station.toml")
    except ConfigError:
        return False
    return True


def test_it_has_every_key_of_every_table() -> None:
    assert set(SCHEMA["properties"]) == set(StationConfig.model_fields)
    for name, part in SCHEMA["$defs"].items():
        assert "properties" in part or name == "FaultConfig"
    axis = SCHEMA["$defs"]["AxisConfig"]["properties"]
    assert set(axis_keys()) < set(axis)
    kinds = [
        each["properties"]["kind"]["const"] for each in SCHEMA["$defs"]["FaultConfig"]["oneOf"]
    ]
    assert kinds == list(STATION_FAULTS)


def test_each_parameter_of_an_axis_has_meaning_and_range() -> None:
    for name in axis_keys():
        field = configurable(name)
        shown = SCHEMA["$defs"]["AxisConfig"]["properties"][name]
        assert field is not None
        assert field.doc in shown["description"]
        number = shown.get("anyOf", [shown])[0]
        assert number.get("maximum", math.inf) == field.most
    assert "lower" in str(SCHEMA["$defs"]["AxisConfig"]["properties"]["encoder_soft_limit_min"])


def test_schema_belongs_to_its_caller() -> None:
    station_schema()["$defs"].clear()
    assert station_schema()["$defs"] == SCHEMA["$defs"]


def test_each_key_that_has_a_text_shows_it() -> None:
    texts = descriptions_of(StationConfig.model_fields["system"].annotation)  # type: ignore[arg-type]
    shown = SCHEMA["$defs"]["SystemConfig"]["properties"]
    assert texts["root"].startswith("Folder that the file services show")
    assert {key: shown[key]["description"] for key in texts} == texts


@pytest.mark.parametrize(
    "document",
    [
        {},
        {"nc": {"cycle": "2ms", "code": "auto"}},
        {"axis": [{"id": 1, "name": "X", "override_type": "original", "max_velocity": 5}]},
        {"axis": [{"id": 1, "name": "X", "element": [{"encoder_scaling_factor": 1.0}]}]},
        {"fault": [{"kind": "drop", "at": "2s", "lasting": "1s", "symbol": "GVL.n"}]},
        {"signal": [{"symbol": "a", "kind": "sine", "period": "1s"}]},
        {"signal": [{"symbol": "a", "kind": "csv", "file": "f", "column": 2}]},
        {"router": {"net_id": "1.2.3.4.1.1", "udp_port": 0}},
        {"plc": [{"task": [{"cycle": "10ms", "programs": ["MAIN"]}], "also": [801]}]},
        {"route": [{"name": "a", "net_id": "1.2.3.4.1.1", "host": "h", "timeout": "1s"}]},
        {"table": [{"id": 1, "points": [[-1.0, -1.0], [1.0, 1.0]]}]},
        {"limits": {"handles": 5}},
    ],
)
def test_what_is_valid_is_valid_for_both(is_valid: Any, document: Any) -> None:
    assert _loads(document)
    assert is_valid(document)


@pytest.mark.parametrize(
    "document",
    [
        {"nope": 1},
        {"nc": {"cycle": 2}},
        {"nc": {"cycle": "2 minutes"}},
        {"nc": {"cylce": "2ms"}},
        {"axis": [{"name": "X"}]},
        {"axis": [{"id": 300, "name": "X"}]},
        {"fault": [{"kind": "flood"}]},
        {"fault": [{"kind": "restart", "size": 3}]},
        {"signal": [{"symbol": "a", "kind": "sin", "period": "1s"}]},
        {"signal": [{"symbol": "a", "kind": "sine"}]},
        {"router": {"net_id": "1.2.3"}},
        {"plc": [{"port": 0}]},
    ],
)
def test_what_is_wrong_is_wrong_for_both(is_valid: Any, document: Any) -> None:
    assert not _loads(document)
    assert not is_valid(document)


def test_the_demo_is_valid(is_valid: Any) -> None:
    demo = ROOT / "src" / "achse" / "station" / "demo.toml"
    assert is_valid(parse_toml(demo.read_text(encoding="utf-8")))


def test_defaults_are_as_a_file_says_them(is_valid: Any) -> None:
    assert SCHEMA["$defs"]["NcConfig"]["properties"]["cycle"]["default"] == "2ms"
    assert SCHEMA["$defs"]["RouterConfig"]["properties"]["host"]["default"] == "127.0.0.1"
    for name, part in SCHEMA["$defs"].items():
        for key, shown in part.get("properties", {}).items():
            assert shown.get("default", 0) is not None, (name, key)
