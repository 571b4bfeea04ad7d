"""[scope] in a station.toml: limits, views, and what cannot be."""

from typing import Any

import pytest

from achse.station.configuration.scope import ScopeConfig, ScopeViewConfig
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError


def test_a_view_is_a_definition() -> None:
    view = ScopeViewConfig.model_validate(
        {
            "name": "press",
            "record_length": "2s",
            "pretrigger": 0.25,
            "channels": ["MAIN.a@2ms", {"symbol": "MAIN.b", "sample_time": "1ms", "scale": 2}],
            "triggers": ["MAIN.a rising 3"],
        }
    )
    definition = view.definition()
    assert definition.record_length == 2.0
    assert [each.sample_time_ns for each in definition.channels] == [2_000_000, 1_000_000]
    assert definition.channels[1].scale == 2.0
    assert str(definition.triggers[0]) == "MAIN.a rising 3"


def test_limits_are_those_of_the_table() -> None:
    assert ScopeConfig(memory=5000, time=0.5).limits().memory == 5000
    assert ScopeConfig(scopes=9).limits().scopes == 9


@pytest.mark.parametrize(
    ("scope", "message"),
    [
        ({"memroy": 5000}, "scope.memroy: no such key; did you mean 'memory'?"),
        ({"time": 2}, "scope.time: .*expected 1 or less"),
        (
            {"view": [{"record_length": "2"}]},
            r"scope.view\[1\].record_length: expected a duration",
        ),
        ({"view": [{"channels": ["a", "a"]}]}, r"scope.view\[1\]: channels: each name once"),
        ({"view": [{"channels": ["a"], "triggers": ["b rising"]}]}, r"triggers\[1\].channel"),
    ],
)
def test_what_cannot_be_is_reported(scope: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse({"scope": scope}, "station.toml")
