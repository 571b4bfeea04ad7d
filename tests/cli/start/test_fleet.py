"""`achse fleet`: the file, a fleet from `up` to `down`, and what is told when it cannot be."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.start.fleet_record import fleets
from tests.warm_commands import EXECUTABLE, WarmCommands


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Records of each test for itself; what still runs at its end is stopped."""
    monkeypatch.setenv("ACHSE_RUNTIME_DIR", str(tmp_path / "runtime"))
    yield tmp_path
    for record in fleets():
        os.kill(record.pid, signal.SIGTERM)


@pytest.fixture
def forked(monkeypatch: pytest.MonkeyPatch, warm_commands: WarmCommands) -> Iterator[None]:
    """The supervisor and the processes that it starts are forked from one that has loaded achse."""
    started: list[subprocess.Popen[str]] = []
    closed = SimpleNamespace(fileno=lambda: -1)

    def popen(words: list[str], **options: Any) -> "subprocess.Popen[str]":
        started.append(warm_commands.popen(*words[3:], **options))
        return started[-1]

    module = SimpleNamespace(Popen=popen, DEVNULL=subprocess.DEVNULL)
    monkeypatch.setattr("achse.cli.start.fleet.subprocess", module)
    monkeypatch.setattr(sys, "executable", str(warm_commands.python))
    monkeypatch.setenv(EXECUTABLE, str(warm_commands.python))
    yield
    for each in started:
        if getattr(each, "line", closed).fileno() >= 0:
            each.returncode = None  # achse says that it has ended: it is not waited for
            each.wait()


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    """Somebody who listens as a broker does, and says nothing."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening


def _cli(*words: str, exit_code: int = 0) -> Any:
    result = CliRunner().invoke(app, ("fleet", *words), env={"COLUMNS": "200"})
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def _fleet(folder: Path, port: int, more: str = "") -> str:
    (folder / "press.toml").write_text('[[axis]]\nid = 1\nname = "X"\n')
    file = folder / "fleet.toml"
    file.write_text(
        'name = "press"\ntemplate = "press.toml"\ncount = 3\nnet_id = "5.6.7.8.1.1"\n'
        f'stations_per_process = 3\nspeed = 0.5\n{more}\n[mqtt]\nbroker = "127.0.0.1"\n'
        f'port = {port}\ntopic = "plant"\n'
    )
    return str(file)


def test_a_fleet_from_up_to_down(folder: Path, listener: socket.socket, forked: None) -> None:
    pytest.importorskip("aiomqtt")
    file = _fleet(folder, listener.getsockname()[1])
    report = json.loads(_cli("up", file, "-d", "--json").stdout)
    assert (report["event"], report["fleet"], report["stations"]) == ("ready", "press", "3")
    assert "runs already" in _cli("up", file, "-d", exit_code=1).stderr
    status = json.loads(_cli("status", "press", "--json").stdout)
    assert [row["name"] for row in status["stations"]] == ["press-1", "press-2", "press-3"]
    assert {row["state"] for row in status["stations"]} <= {"RUN", "running"}
    [pid] = {row["pid"] for row in status["stations"]}
    shown = _cli("status").stdout
    assert "press-2 5.6.7.9.1.1 " in " ".join(shown.split())
    assert _cli("restart", "-s", "5.6.7.9.1.1").stdout.endswith("press-1, press-2, press-3\n")
    assert "no station saw" in _cli("restart", "-s", "saw", exit_code=1).stderr
    log = json.loads(_cli("logs", file, "-s", "PRESS-1", "--json").stdout)
    assert Path(log["file"]).name == "process-1.log"
    assert _cli("down").stdout == "fleet press has ended\n"
    assert fleets() == []
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    _cli("logs", file)  # of its last run
    assert "no fleet runs" in _cli("down", exit_code=1).stderr


def test_in_the_foreground_it_ends_by_a_signal(folder: Path, listener: socket.socket) -> None:
    pytest.importorskip("aiomqtt")
    file = _fleet(folder, listener.getsockname()[1])
    command = (sys.executable, "-m", "achse", "fleet", "up", file)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        ready = process.stdout.readline()
        assert ready == "achse ready fleet=press stations=3 processes=1\n"
        [pid] = {row["pid"] for row in fleets()[0].order("status")}
        process.kill()  # even so its stations end: nobody looks after them
    while Path(f"/proc/{pid}").exists():
        pass


def test_stations_that_do_not_start_are_reported(
    folder: Path, listener: socket.socket, forked: None
) -> None:
    pytest.importorskip("aiomqtt")
    file = _fleet(folder, listener.getsockname()[1])
    (folder / "press.toml").write_text(f"[router]\ntcp_port = {listener.getsockname()[1]}\n")
    stderr = _cli("up", file, exit_code=1).stderr
    assert "press-1 did not start:" in stderr
    assert "ddress already in use" in stderr


def test_without_a_broker_it_says_so_and_where(folder: Path) -> None:
    pytest.importorskip("aiomqtt")
    stderr = _cli("up", _fleet(folder, 1), exit_code=1).stderr
    assert "fleet.toml:9: no broker at 127.0.0.1:1: " in stderr
    assert "start one (`mosquitto`)" in stderr
    stderr = _cli("up", _fleet(folder, 1), "--broker", "127.0.0.1:2", exit_code=1).stderr
    assert "no broker at 127.0.0.1:2: " in stderr


def test_faults_of_the_file_have_their_line(folder: Path) -> None:
    stderr = _cli("up", _fleet(folder, 1, "colour = 1"), exit_code=1).stderr
    assert "fleet.toml:7: colour: no such key" in stderr
    assert "No such file" in _cli("up", str(folder / "gone.toml"), exit_code=1).stderr
    stderr = _cli("up", _fleet(folder, 1, "cores = [9999]"), exit_code=1).stderr
    assert "fleet.toml:7: cores: there are" in stderr


@pytest.mark.parametrize(
    ("words", "numbers"),
    [
        (("2",), [2]),
        (("2-4",), [2, 3, 4]),
        (("press-2",), [2]),
        (("press-2", "--process"), [4, 5]),
        (("1", "--process"), [1, 2, 3]),
    ],
)
def test_stations_by_number_name_and_process(
    folder: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], numbers: list[int]
) -> None:
    served: list[int] = []

    async def serve(plan: Any, wanted: list[int], *_: Any, **options: Any) -> None:
        served.extend(wanted)
        assert options["alone"] == (len(wanted) == 1)

    monkeypatch.setattr("achse.fleet.worker.serve", serve)
    file = Path(_fleet(folder, 1))
    file.write_text(file.read_text().replace("count = 3", "count = 5"))
    word, *options = words
    _cli("up", str(file), "--station", word, *options)
    assert served == numbers


@pytest.mark.parametrize(
    ("word", "message"),
    [("4", "stations 1 … 3, not 4"), ("x", "expected 3, 3-7"), ("3-2", "smaller number first")],
)
def test_which_station(folder: Path, word: str, message: str) -> None:
    result = CliRunner().invoke(app, ("fleet", "up", _fleet(folder, 1), "--station", word))
    assert result.exit_code
    assert message in " ".join(result.stderr.split())
