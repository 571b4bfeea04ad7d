"""Logs on stderr, as lines or as JSON."""

import json
import logging
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import achse
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.testing import LiveStation
from tests.warm_commands import PIPES, WarmCommands


@pytest.fixture(autouse=True)
def restored() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    yield
    root.handlers, root.level = handlers, level


def test_a_json_document_per_record(capsys: pytest.CaptureFixture[str]) -> None:
    set_up_logs(LogFormat.JSON, LogLevel.INFO)
    log = logging.getLogger("achse.somewhere")
    log.debug("too much")
    log.info("axis %d says „%s“", 3, "no", extra={"client": "1.2.3.4.1.1:30000", "peer": ""})
    try:
        1 / 0  # noqa: B018
    except ZeroDivisionError:
        log.exception("broken")
    logging.getLogger().handlers[0].flush()
    first, second = map(json.loads, capsys.readouterr().err.splitlines())
    assert first["message"] == "axis 3 says „no“"
    assert (first["level"], first["logger"]) == ("info", "achse.somewhere")
    assert first["time"].endswith("Z")
    assert first["client"] == "1.2.3.4.1.1:30000"
    assert "peer" not in first
    assert "ZeroDivisionError" in second["traceback"]


def test_lines_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    set_up_logs(LogFormat.TEXT, LogLevel.WARNING)
    logging.getLogger("achse.tcp").warning("closing it")
    logging.getLogger().handlers[0].flush()
    assert capsys.readouterr().err.rstrip().endswith("WARNING achse.tcp: closing it")


def test_a_station_logs_what_it_closes(
    free_host: Callable[[], str], warm_commands: WarmCommands
) -> None:
    import socket

    host = free_host()
    arguments = ["run", "--host", host, "--log-format", "json"]
    with warm_commands.popen(*arguments, **PIPES) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with socket.create_connection((host, 48898)) as alien:
            alien.sendall(b"GET / HTTP/1.1\r\n\r\n")
            assert alien.recv(1) == b""
        assert process.stderr is not None
        record: dict[str, Any] = json.loads(process.stderr.readline())
        process.terminate()
        process.communicate()
    assert (record["level"], record["logger"]) == ("warning", "achse.tcp")
    assert record["message"].startswith(f"closing {record['peer']}: ")


def test_clients_that_come_and_go_are_named(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="achse.tcp"), LiveStation() as station:
        with achse.blocking.connect(station.host) as client:
            client.state()
        while sum(" has " in text for text in caplog.messages) < 2:
            station.run(lambda: None)  # the loop of the station turns once more
    come, left = (record for record in caplog.records if " has " in record.getMessage())
    assert " has come, client 127." in come.getMessage()
    assert left.getMessage() == come.getMessage().replace("come", "left")
    assert come.peer == left.peer == come.getMessage().split()[0]  # type: ignore[attr-defined]
