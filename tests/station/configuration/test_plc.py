"""[[plc]]: where its variables come from, and what goes with that."""

from typing import Any

import pytest

from achse.station.configuration.plc import PlcConfig
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"sources": "a.st", "symbols": "a.tmc"}, "either sources or symbols, not both"),
        ({"libraries": ["l"]}, "libraries go with sources"),
        ({"symbols": "a.tmc", "unknown_types": "opaque"}, "unknown_types goes with sources"),
        ({"port": 0}, "port"),
        ({"task": [{"priority": 256}]}, "priority"),
    ],
)
def test_keys_that_do_not_go_together_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse({"plc": [keys]}, "a.toml")


def test_a_plc_has_variables_of_one_origin() -> None:
    [plc] = parse({"plc": [{"sources": "a.st", "libraries": ["l"]}]}, "a.toml").plc
    assert plc == PlcConfig(sources="a.st", libraries=["l"])
    assert plc.symbols is None
