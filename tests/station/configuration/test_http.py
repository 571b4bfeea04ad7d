"""[web] in a station.toml."""

import pytest

from achse.station import ConfigError
from achse.station.configuration.station_file import parse


def test_defaults_and_values() -> None:
    assert parse({}, "a.toml").web.port is None
    web = parse({"web": {"port": 0, "token": "a-b_c", "read_only": True}}, "a.toml").web
    assert (web.port, web.host, web.read_only) == (0, "127.0.0.1", True)


@pytest.mark.parametrize(
    ("table", "message"),
    [({"port": 70_000}, "web.port"), ({"token": "a b"}, "web.token"), ({"ports": 1}, "web.ports"),
     ({"host": ""}, "web.host")],
)  # fmt: skip
def test_what_cannot_be_is_named(table: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse({"web": table}, "a.toml")
