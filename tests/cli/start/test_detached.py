"""Stations that run without a terminal: started, waited for, stopped, and their records."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.start.detached import (
    DetachedStation,
    detached_stations,
    recorded,
    runtime_folder,
)
from tests.warm_commands import PIPES, WarmCommands

STATION = DetachedStation(7, "Cell", "127.0.0.1", 48898, "5.1.1.1.1.1", "x.log")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Records of each test for itself; what still runs at its end is stopped."""
    folder = tmp_path / "runtime"
    monkeypatch.setenv("ACHSE_RUNTIME_DIR", str(folder))
    yield folder
    for station in detached_stations():
        os.kill(station.pid, signal.SIGKILL)


@pytest.fixture
def forked(monkeypatch: pytest.MonkeyPatch, warm_commands: WarmCommands) -> Iterator[None]:
    """Stations are forked from a process that has loaded achse; others are new interpreters."""
    started: list[subprocess.Popen[str]] = []
    closed = SimpleNamespace(fileno=lambda: -1)

    def popen(words: list[str], **options: Any) -> "subprocess.Popen[str]":
        started.append(warm_commands.popen(*words[3:], **options))
        return started[-1]

    module = SimpleNamespace(Popen=popen, DEVNULL=subprocess.DEVNULL)
    monkeypatch.setattr("achse.cli.start.detached.subprocess", module)
    yield
    for each in started:
        if getattr(each, "line", closed).fileno() >= 0:
            each.returncode = None  # achse says that it has ended: it is not waited for
            each.kill()
            each.wait()


def _cli(*words: str, exit_code: int = 0) -> Any:
    result = CliRunner().invoke(app, words, env={"COLUMNS": "200"})
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


@pytest.fixture
def config(tmp_path: Path) -> Path:
    file = tmp_path / "station.toml"
    file.write_text(
        'name = "Cell"\n[system]\npersistent_data = "kept.json"\n'
        '[[axis]]\nid = 1\nname = "X"\npersistent_data_enable = true\n'
    )
    return file


def test_a_station_is_started_waited_for_and_stopped(config: Path, folder: Path) -> None:
    report = json.loads(_cli("run", str(config), "--detach", "--tcp-port", "0", "--json").stdout)
    assert report["name"] == "Cell"
    assert Path(report["log"]).parent == folder
    assert detached_stations() == [DetachedStation(**report)]
    address = f"127.0.0.1:{report['tcp_port']}"
    assert _cli("wait", "cell").stdout == f"{address} is ready\n"
    assert json.loads(_cli("wait", address, "--json").stdout)["state"] == "RUN"
    assert "no detached station 'other'" in _cli("stop", "other", exit_code=1).stderr
    assert _cli("stop", address).stdout == f"Cell at {address} has ended\n"
    assert json.loads((config.parent / "kept.json").read_text())["nc"]
    assert detached_stations() == []
    assert not list(folder.glob("*.json"))
    assert f"no detached station runs: no records in {folder}" in _cli("stop", exit_code=1).stderr


@pytest.mark.usefixtures("forked")
def test_of_several_the_name_is_needed_or_all(config: Path) -> None:
    for _ in range(2):
        _cli("run", str(config), "-d", "--tcp-port", "0")
    stderr = _cli("stop", exit_code=1).stderr
    assert "which one?" in stderr
    assert stderr.count("Cell at 127.0.0.1:") == 2
    assert "which one? say its process id" in _cli("stop", "Cell", exit_code=1).stderr
    stopped = json.loads(_cli("stop", "--all", "--json").stdout)
    assert [each["name"] for each in stopped] == ["Cell", "Cell"]
    assert _cli("stop", "--all").stdout == "no detached station runs\n"


@pytest.mark.usefixtures("forked")
def test_a_station_that_cannot_start_says_why(tmp_path: Path, folder: Path) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("[nc]\ncycle = 1\n")
    stderr = _cli("run", str(wrong), "--detach", exit_code=1).stderr
    assert "wrong.toml: nc.cycle: expected a duration" in stderr
    assert not list(folder.iterdir())


@pytest.mark.usefixtures("forked")
def test_a_killed_station_leaves_a_record_that_is_cleaned(config: Path, folder: Path) -> None:
    report = json.loads(_cli("run", str(config), "-d", "--tcp-port", "0", "--json").stdout)
    os.kill(report["pid"], signal.SIGKILL)
    while detached_stations():
        pass
    assert not list(folder.glob("*.json"))
    assert Path(report["log"]).exists()  # it may say why


def test_old_logs_go(folder: Path) -> None:
    log = runtime_folder() / "detached-1.log"
    log.write_text("long ago")
    os.utime(log, (0, 0))
    assert detached_stations() == []
    assert not log.exists()


def test_what_is_not_a_record_harms_no_other(folder: Path) -> None:
    (runtime_folder() / "detached-1.json").write_text("{not json")
    assert detached_stations() == []


@pytest.mark.skipif(sys.platform != "linux", reason="PID namespaces are Linux")
def test_a_station_in_a_container_is_stopped_by_its_own_process_id(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its record has the process id that the container gave it: here that is another process."""
    here = str(Path("/proc/self/ns/pid").readlink())
    signalled: list[int] = []
    monkeypatch.setattr(os, "kill", lambda pid, number: signalled.append(pid))
    monkeypatch.setattr("achse.cli.start.detached._pid_namespace", lambda: "pid:[1]")
    STATION._replace(pid=os.getpid(), pid_namespace=here).terminate()
    assert signalled == [os.getpid()]
    with pytest.raises(ProcessLookupError, match=r"no process 7 in pid:\[2\] is visible here"):
        STATION._replace(pid_namespace="pid:[2]").terminate()
    assert signalled == [os.getpid()]


@pytest.mark.skipif(sys.platform != "linux", reason="network namespaces are Linux")
@pytest.mark.parametrize("allowed", [True, False])
def test_station_in_another_network_is_waited_for_there(
    allowed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    entered: list[Path] = []

    def enter(namespace: Path) -> None:
        entered.append(namespace)
        if not allowed:
            raise PermissionError(1, "Operation not permitted")

    async def answer(host: str, tcp_port: int, end: float) -> str:
        return "RUN"

    own, readlink = Path("/proc/self/ns/net"), Path.readlink
    monkeypatch.setattr("achse.cli.start.detached._use_namespace", enter)
    monkeypatch.setattr("achse.cli.start.detached._answer", answer)
    monkeypatch.setenv("ACHSE_DETACHED", str(runtime_folder()))
    with recorded("Cell", "127.0.0.1", 1, "1.1.1.1.1.1"):
        assert "127.0.0.1:1 is ready" in _cli("wait", "Cell").stdout
        assert entered == []
        monkeypatch.setattr(
            Path, "readlink", lambda self: Path("net:[1]") if self == own else readlink(self)
        )
        run = _cli("wait", "Cell", exit_code=0 if allowed else 1)
    assert entered == [Path(f"/proc/{os.getpid()}/ns/net")]
    assert allowed or "is in another network namespace: Operation not permitted" in run.stderr


def test_a_station_in_a_container_that_is_out_of_sight_is_not_signalled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ACHSE_DETACHED", str(runtime_folder()))
    monkeypatch.setattr("achse.cli.start.detached._pid_namespace", lambda: "pid:[2]")
    with recorded("Cell", "127.0.0.1", 1, "1.1.1.1.1.1"):
        monkeypatch.setattr("achse.cli.start.detached._pid_namespace", lambda: "pid:[1]")
        stderr = _cli("stop", "Cell", exit_code=1).stderr
    assert "runs in another container: stop it there" in stderr


@pytest.mark.parametrize("word", ["cell", "127.0.0.1:48898", "48898", "5.1.1.1.1.1", "7"])
def test_a_station_is_called_by(word: str) -> None:
    assert STATION.is_called(word)
    assert not STATION.is_called(word + "0")


def test_only_a_detached_station_keeps_a_record(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorded("Cell", "::1", 1, "1.1.1.1.1.1"):
        assert not folder.exists()
    monkeypatch.setenv("ACHSE_DETACHED", str(runtime_folder()))
    with recorded("Cell", "::1", 1, "1.1.1.1.1.1"):
        [station] = detached_stations()
        assert (station.address, station.pid) == ("[::1]:1", os.getpid())
        assert "ACHSE_DETACHED" not in os.environ
    assert detached_stations() == []


def test_waiting_ends_with_the_time() -> None:
    stderr = _cli("wait", "--tcp-port", "1", "--timeout", "0.1", exit_code=1).stderr
    assert "127.0.0.1:1 is not ready after 0.1 s: cannot connect" in stderr


@pytest.mark.usefixtures("forked")
def test_a_station_that_is_started_meanwhile_is_waited_for(
    free_host: Callable[[], str], warm_commands: WarmCommands
) -> None:
    host = free_host()
    waiting = warm_commands.popen("wait", "--host", host, "--timeout", "3600", **PIPES)
    _cli("run", "--detach", "--host", host)
    assert waiting.communicate()[0] == f"{host}:48898 is ready\n"
    _cli("stop", host + ":48898")


@pytest.mark.skipif(sys.platform == "win32", reason="folders have no such rights there")
def test_the_folder_is_the_users_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert runtime_folder().stat().st_mode & 0o077 == 0
    monkeypatch.delenv("ACHSE_RUNTIME_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert runtime_folder() == tmp_path / "achse"
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/does/not/exist")
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert runtime_folder() == tmp_path / ".cache" / "achse" / "run"


@pytest.mark.skipif(sys.platform == "win32", reason="folders have no such rights there")
def test_without_a_home_records_are_below_the_temporary_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("ACHSE_RUNTIME_DIR", "XDG_RUNTIME_DIR", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/dev/null")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = tmp_path / f"achse-{os.getuid()}"
    assert runtime_folder() == folder
    folder.chmod(0o777)
    refused = CliRunner().invoke(app, ["stop"])
    assert refused.exit_code == 1
    assert "belongs to another user" in refused.stderr
    folder.chmod(0o700)


def test_a_folder_that_cannot_be_made_is_reported() -> None:
    for words in (["stop"], ["stop", "--all"], ["wait", "cell"], ["run", "--detach"]):
        refused = CliRunner().invoke(app, words, env={"ACHSE_RUNTIME_DIR": "/dev/null/x"})
        assert refused.exit_code == 1
        assert "/dev/null/x: Not a directory" in refused.stderr


@pytest.mark.usefixtures("forked")
def test_a_port_in_use_names_the_station_that_has_it(
    config: Path, warm_commands: WarmCommands
) -> None:
    _cli("run", str(config), "--detach", "--tcp-port", "0")
    [station] = detached_stations()
    for flag in ((), ("--detach",)):
        refused = warm_commands.run("run", "--tcp-port", str(station.tcp_port), *flag)
        assert refused.returncode == 1
        assert f"Cell at {station.address}, process {station.pid} is there" in refused.stderr


def _is_pending(pid: int, number: signal.Signals) -> bool:
    """Whether a signal waits for a stopped process."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    [pending] = [line.split()[1] for line in status.splitlines() if line.startswith("ShdPnd:")]
    return bool(int(pending, 16) & 1 << (number - 1))


@pytest.mark.usefixtures("forked")
def test_stop_ends_where_the_station_is_killed_meanwhile(
    config: Path, warm_commands: WarmCommands
) -> None:
    _cli("run", str(config), "--detach", "--tcp-port", "0")
    [station] = detached_stations()
    os.kill(station.pid, signal.SIGSTOP)  # deaf to `stop`
    stopping = warm_commands.popen("stop", "--timeout", "3600")
    while not _is_pending(station.pid, signal.SIGTERM):
        assert stopping.poll() is None
    os.kill(station.pid, signal.SIGKILL)
    assert stopping.wait() == 0
