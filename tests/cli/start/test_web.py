"""`achse web` and `achse run --web`: the address of the page, and what is in the way of it."""

import socket
import urllib.request
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from typer.testing import CliRunner

from achse.cli.app import app

Starts = Callable[..., AbstractContextManager[Any]]


def test_a_station_reports_where_its_page_is(start_station: Starts) -> None:
    with start_station("--web-port", "0") as station:
        line = station.process.stdout.readline()
        assert line.startswith("achse web url=http://127.0.0.1:")
        with urllib.request.urlopen(line.split("url=")[1].strip()) as page:
            assert b"<html" in page.read()


def test_a_port_that_is_taken_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        result = CliRunner().invoke(app, ["run", "--tcp-port", "0", "--web-port", port])
    assert result.exit_code == 1
    assert f"the page cannot listen on 127.0.0.1:{port}" in result.stderr
    assert "--web-port" in result.stderr


def test_a_target_is_needed(free_host: Callable[[], str]) -> None:
    result = CliRunner().invoke(app, ["web", "--host", free_host(), "--web-port", "0"])
    assert result.exit_code == 1
    assert "cannot connect" in result.stderr
