"""[[bridge]]: names of symbols that can be topics."""

import pytest

from achse.station import ConfigError
from achse.station.configuration.station_file import parse

TABLE = {"broker": "b", "topic": "press", "symbols": ["MAIN.x"]}


@pytest.mark.parametrize("key", ["symbols", "writable"])
@pytest.mark.parametrize("name", ["", "a/b", "a+", "#", "x" * 256])
def test_name_that_is_no_topic_is_refused(key: str, name: str) -> None:
    with pytest.raises(ConfigError, match="expected the name of a symbol"):
        parse({"bridge": [{**TABLE, key: [name]}]}, "a.toml")


@pytest.mark.parametrize("wrong", [{"broker": ""}, {"topic": "a/#"}, {"symbols": []}, {"port": -1}])
def test_bridge_that_cannot_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="bridge"):
        parse({"bridge": [{**TABLE, **wrong}]}, "a.toml")
