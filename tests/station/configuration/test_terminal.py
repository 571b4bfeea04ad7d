"""[[terminal]]: defaults by kind, limits."""

import pytest

from achse.station.configuration.station_file import parse
from achse.station.configuration.terminal import TerminalConfig
from achse.station.configuration.types import ConfigError


def test_channels_unless_given() -> None:
    digital, analog = TerminalConfig(name="a"), TerminalConfig(name="b", kind="analog", inputs=0)
    assert (digital.input_count, digital.output_count) == (16, 16)
    assert (analog.input_count, analog.output_count) == (0, 4)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"inputs": 65}, "64"),
        ({"kind": "analog", "outputs": 9}, "at most 8"),
        ({"inputs": 0, "outputs": 0}, "inputs or outputs"),
        ({"name": ""}, "name"),
        ({"input_address": -1}, "input_address"),
    ],
)
def test_what_cannot_be(fields: dict[str, object], message: str) -> None:
    with pytest.raises((ConfigError, ValueError), match=message):
        TerminalConfig(**{"name": "a", **fields})  # type: ignore[arg-type]


def test_they_are_part_of_a_station() -> None:
    config = parse({"terminal": [{"name": "Term 1"}]}, "a.toml")
    assert config.terminal[0].name == "Term 1"
    with pytest.raises(ConfigError, match="terminal"):
        parse({"terminal": [{"name": "a", "inputs": 99}]}, "a.toml")
