"""The forked command is like the real one to a program that starts it."""

import json
import os
import selectors
import signal
import socket
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.warm_commands import Server, WarmCommands, is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="this system forks no commands")

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture(params=["popen", "folder"])
def start(request: pytest.FixtureRequest, warm_commands: WarmCommands) -> Start:
    """Both ways to a forked command, with pipes."""

    def run(*words: str, **options: Any) -> "subprocess.Popen[str]":
        pipe = subprocess.PIPE
        options = {"stdin": pipe, "stdout": pipe, "stderr": pipe, "text": True} | options
        if request.param == "popen":
            return warm_commands.popen(*words, **options)
        return subprocess.Popen([str(warm_commands.folder / "achse"), *words], **options)

    return run


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("--version",), 0),
        (("axis", "--help"), 0),
        (("axis", "nothing"), 2),
        (("ads", "state", "--identity", "--host", "127.0.0.1", "--tcp-port", "1", "--json"), 1),
    ],
)
def test_results_are_those_of_the_real_command(
    warm_commands: WarmCommands, words: tuple[str, ...], code: int
) -> None:
    forked, real = warm_commands.run(*words), warm_commands.run(*words, real=True)
    assert (forked.returncode, forked.stdout, forked.stderr) == (code, real.stdout, real.stderr)


def test_folder_and_environment_are_the_callers(start: Start, tmp_path: Path) -> None:
    (tmp_path / "here.toml").write_text("[[axes]]\nname = 7\n", encoding="utf-8")
    environment = os.environ | {"ACHSE_HOST": "nowhere.invalid"}
    with start("check", "here.toml", "--json", cwd=tmp_path) as process:
        assert "here.toml" in process.communicate()[1]
    with start("axis", "show", "--json", env=environment) as process:
        assert "nowhere.invalid" in json.loads(process.communicate()[1])["message"]


def test_input_is_read_from_the_pipe(start: Start) -> None:
    with start("hash-password") as process:
        output, errors = process.communicate("secret\n")
    assert (process.returncode, errors) == (0, "")
    assert output.startswith("scrypt:")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_reaches_the_command(start: Start, number: signal.Signals) -> None:
    with start("run", "--tcp-port", "0") as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("achse ready ")
        assert process.poll() is None
        process.send_signal(number)
        assert process.wait() == 0
        assert process.poll() == 0


def test_killed_command_returns_its_signal(warm_commands: WarmCommands) -> None:
    with warm_commands.popen("run", "--tcp-port", "0", stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("achse ready ")
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.001)
        process.kill()
        assert process.wait() == -signal.SIGKILL


def test_command_ends_with_its_killed_caller(warm_commands: WarmCommands) -> None:
    stub = [str(warm_commands.folder / "achse"), "run", "--tcp-port", "0"]
    with subprocess.Popen(stub, stdout=subprocess.PIPE, text=True) as caller:
        assert caller.stdout is not None
        assert caller.stdout.readline().startswith("achse ready ")
        caller.kill()
        assert caller.stdout.read() == ""  # the command has closed it


def test_session_may_be_its_own(warm_commands: WarmCommands) -> None:
    options: dict[str, Any] = {"stdout": subprocess.PIPE, "start_new_session": True}
    with warm_commands.popen("run", "--tcp-port", "0", **options) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("achse ready ")
        assert os.getsid(process.pid) == process.pid
        os.killpg(process.pid, signal.SIGTERM)
        assert process.wait() == 0


def test_a_process_and_its_caller_may_end_at_once() -> None:
    server = object.__new__(Server)
    with selectors.DefaultSelector() as server.selector:
        line, caller = socket.socketpair()
        process = subprocess.Popen(["true"])
        server.watch(line, process.pid)
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        caller.close()
        events = server.selector.select()
        assert len(events) == 2
        for key, _ in sorted(events, key=lambda event: event[0].fileobj is line):
            key.data(key.fileobj)
        process.returncode = 0  # its end was taken by the server
        assert line.fileno() < 0
