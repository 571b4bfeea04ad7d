"""Logs on stderr, as lines or as JSON."""

import json
import logging
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from achse.cli.logs import LogFormat, LogLevel, set_up_logs


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


def test_a_station_logs_what_it_closes(free_host: Callable[[], str]) -> None:
    import socket

    host = free_host()
    arguments = ["run", "--host", host, "--log-format", "json"]
    with subprocess.Popen(
        [sys.executable, "-m", "achse", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with socket.create_connection((host, 48898)) as alien:
            alien.sendall(b"GET / HTTP/1.1\r\n\r\n")
            assert alien.recv(1) == b""
        assert process.stderr is not None
        record: dict[str, Any] = json.loads(process.stderr.readline())
        process.terminate()
        process.communicate(timeout=60)
    assert (record["level"], record["logger"]) == ("warning", "achse.tcp")
    assert record["message"].startswith(f"closing {record['peer']}: ")
