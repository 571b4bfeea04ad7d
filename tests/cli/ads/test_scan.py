"""`achse ads scan`."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app


@pytest.fixture(scope="module")
def station(
    start_station: Callable[..., Any],
) -> Iterator[Any]:
    with start_station() as station:
        yield station


def scan(*arguments: str, host: str = "", exit_code: int = 0) -> Any:
    environment = {"ACHSE_HOST": host, "COLUMNS": "100"}
    result = CliRunner().invoke(
        app, ["ads", "scan", "--timeout", "0.3", *arguments], env=environment
    )
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_a_station_is_found_with_name_address_and_version(station: Any) -> None:
    [line] = scan(station.host).stdout.splitlines()
    assert line.split()[:4] == [station.net_id, "demo", station.host, "3.1.4024"]


@pytest.mark.parametrize("tcp_port", ["", ":48898"])
def test_without_a_host_the_environment_says_where(station: Any, tcp_port: str) -> None:
    [line] = scan(host=station.host + tcp_port).stdout.splitlines()
    assert line.startswith(station.net_id)


def test_json(station: Any) -> None:
    import json

    [facts] = json.loads(scan(station.host, "--json").stdout)
    assert facts["net_id"] == station.net_id
    assert facts["version"] == "3.1.4024"


def test_without_an_answer_it_says_so() -> None:
    stderr = scan("127.0.0.1", "--udp-port", "1", exit_code=1).stderr
    assert stderr == "no answer at 127.0.0.1, UDP port 1\n"


def test_an_unknown_host_is_named() -> None:
    assert "no.such.host.invalid: " in scan("no.such.host.invalid", exit_code=1).stderr
