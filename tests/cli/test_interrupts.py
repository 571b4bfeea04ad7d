"""Ctrl-C at any moment: no traceback, an exit code of its own, nothing left behind."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from achse.cli.interrupts import (
    INTERRUPTED,
    Interrupted,
    ending,
    ending_signals,
    leave_at_once,
    run,
    serve,
)
from achse.scope import ScopeData
from achse.station.configuration.types import ConfigError
from achse.testing import LiveStation
from tests.warm_commands import PIPES, WarmCommands

START = """
import os, signal, sys
signal.signal(signal.SIGINT, lambda *_: os._exit(130))  # until achse is loaded
import achse.cli
os.write(2, b"go\\n")
sys.argv[0] = "achse"
achse.cli.main()
"""
"""The command, which says on stderr when it begins: from there on Ctrl-C is ours."""

COMMANDS = {
    "--help": (0,),
    "ads state --identity": (0,),
    "ads read --watch MAIN.nCounter": (0,),
    "symbols --json": (0,),
    "axis move X --to 1e6 --velocity 10": (0, 1),
    "axis jog X --for 30": (0, 1),
    "axis show X --watch": (0,),
    "monitor": (0,),
    "check {folder}/station.toml": (0,),
    "run {folder}/station.toml --tcp-port 0": (0,),
    "run --tcp-port 0 --speed max --for 3600": (0,),
    "wait 1.2.3.4": (1,),
    "docs --out {folder}/docs": (0,),
    "symbols --to -": (0,),
    "drive objects": (0,),
    "drive serve --udp 127.0.0.1:0 --control none --code plain --ordinary": (0,),
    "fault list": (0,),
    "warmup": (0, 1),
    "scope record {folder}/a.csv MAIN.nCounter": (0, 1),
}
"""Commands, and with what they may end if the signal does not find them any more; a command that
Ctrl-C ends in order may end so, too."""

DELAYS: tuple[float, ...] = (0.0, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.45, 0.8)
SHARES = 3
"""Each command takes every third moment, the next command the moments after; `--deep` all."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("interrupts")
    (folder / "station.toml").write_text('name = "x"\n[[axis]]\nid = 1\nname = "X"\n')
    return folder


@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_at_any_moment_prints_no_traceback(
    folder: Path, command: str, pytestconfig: pytest.Config, warm_commands: WarmCommands
) -> None:
    """One moment of each command finds a real process, which may still load modules."""
    words = command.format(folder=folder).split()
    delays = DELAYS
    if not pytestconfig.option.deep:
        delays = DELAYS[list(COMMANDS).index(command) % SHARES :: SHARES]
    real = delays[list(COMMANDS).index(command) // SHARES % len(delays)]
    codes = {*COMMANDS[command], INTERRUPTED}
    with LiveStation() as station:
        station.run(lambda: None)
        for delay in delays:
            environment = os.environ | {
                "ACHSE_HOST": station.host,
                "ACHSE_RUNTIME_DIR": str(folder),
            }
            options: dict[str, Any] = PIPES | {"stdout": subprocess.DEVNULL, "env": environment}
            if delay == real or pytestconfig.option.deep:
                program = [sys.executable, "-c", START, *words]
                process = subprocess.Popen(program, text=True, **options)
                assert process.stderr is not None
                assert process.stderr.readline() == "go\n"
            else:
                process = warm_commands.popen(*words, **options)
            time.sleep(delay)  # any moment will do
            process.send_signal(signal.SIGINT)
            time.sleep(delay / 10)
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            _, errors = process.communicate()
            assert "Traceback" not in errors, (delay, errors)
            assert "Exception ignored" not in errors, (delay, errors)
            assert "KeyboardInterrupt" not in errors, (delay, errors)
            # -2: the interpreter itself is already going
            assert process.returncode in {*codes, -signal.SIGINT}, (delay, errors)


@pytest.mark.parametrize("trigger", [(), ("--trigger", "MAIN.nCounter above 1e9")])
def test_ctrl_c_ends_a_recording_and_keeps_it(
    tmp_path: Path, trigger: tuple[str, ...], warm_commands: WarmCommands
) -> None:
    file = tmp_path / "a.scope"
    words = ("scope", "record", str(file), "MAIN.nCounter", *trigger)
    with LiveStation() as station:
        environment = {"ACHSE_HOST": station.host, "ACHSE_RUNTIME_DIR": str(tmp_path)}
        process = warm_commands.popen(*words, env=os.environ | environment, **PIPES)
        assert process.stdout is not None
        begun = process.stdout.readline()
        assert begun.startswith("achse recording scope=")
        begin = station.time
        while station.time < begin + 0.3:
            pass
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")
    samples = len(ScopeData.load(file)["MAIN.nCounter"])
    assert samples > 0
    assert output == f"{file}: 1 channels, {samples} samples\n"


EARLY = """
import os, runpy, signal, sys

class Finder:
    def find_spec(self, name, *_):
        if name == "achse.cli":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
known = set(sys.modules)
sys.argv = ["achse", "--version"]
{start}
"""
"""Ctrl-C comes when the first module of the command line is about to be loaded."""


@pytest.mark.parametrize(
    "start",
    ["runpy.run_module('achse', run_name='__main__')", "from achse.__main__ import main; main()"],
)
def test_ctrl_c_while_the_command_line_loads_ends_it_silently(start: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", EARLY.replace("{start}", start)],
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "")


def test_nothing_else_is_loaded_before_ctrl_c_is_minded() -> None:
    text = "import os, signal, sys; known = set(sys.modules); import achse.__main__; "
    text += "print(sorted(set(sys.modules) - known))"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout == "['achse', 'achse.__main__']\n"


def test_the_job_ends_in_order_or_reports_which_signal_ended_it() -> None:
    async def orderly() -> str:
        os.kill(os.getpid(), signal.SIGINT)
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            return "in order"
        return "not at all"

    async def cut_off() -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        await asyncio.Event().wait()

    before = signal.getsignal(signal.SIGINT)
    assert run(orderly()) == "in order"
    with pytest.raises(Interrupted) as interrupted:
        run(cut_off())
    assert interrupted.value.exit_code == 143
    assert signal.getsignal(signal.SIGINT) is before


def test_handlers_come_and_go() -> None:
    came: list[int] = []
    before = signal.getsignal(signal.SIGTERM)
    with ending(came.append):
        os.kill(os.getpid(), signal.SIGTERM)
        while not came:
            pass
    assert came == [signal.SIGTERM]
    assert signal.getsignal(signal.SIGTERM) is before


def test_ctrl_c_leaves_silently_from_now_on(tmp_path: Path) -> None:
    text = "import signal; from achse.cli.interrupts import leave_at_once; leave_at_once();"
    text += "signal.raise_signal(signal.SIGINT)"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, b"", b"")


def test_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        leave_at_once()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="needs SIGHUP")
def test_a_terminal_that_closes_stops_the_axis_that_is_jogged(
    warm_commands: WarmCommands,
) -> None:
    """It went on without end."""
    with LiveStation() as station:
        environment = os.environ | {"ACHSE_HOST": station.host}
        assert warm_commands.run("axis", "enable", "X", env=environment).returncode == 0
        reader, writer = os.openpty()
        jog = warm_commands.popen(
            *("axis", "jog", "X", "--for", "600"),
            stdin=writer, stdout=writer, stderr=writer, env=environment, start_new_session=True,
            real=True,
        )  # fmt: skip
        os.close(writer)

        def moving() -> bool:
            stdout = warm_commands.run("axis", "show", "X", "--json", env=environment).stdout
            [x] = json.loads(stdout)
            return "not moving" not in x["flags"]

        while not moving():
            assert jog.poll() is None
        os.close(reader)  # no terminal any more: what is printed fails, too
        jog.send_signal(signal.SIGHUP)
        assert jog.wait() == 1
        assert not moving()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="needs SIGHUP")
def test_under_nohup_a_program_stays() -> None:
    assert signal.SIGHUP in ending_signals()
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert ending_signals() == [signal.SIGINT, signal.SIGTERM]
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    ("failure", "message"),
    [
        (None, ""),
        (ConfigError("router.host: expected an address"), "router.host: expected"),
        (OSError(98, "Address already in use"), "Address already in use"),
        (UnicodeError("label too long"), "this is not a host name"),
    ],
)
def test_server_ends_by_a_signal_or_says_why_it_cannot_start(
    failure: Exception | None, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    async def until(stopped: asyncio.Event) -> None:
        if failure is not None:
            raise failure
        signal.raise_signal(signal.SIGTERM)
        await stopped.wait()

    before = signal.getsignal(signal.SIGTERM)
    code = asyncio.run(serve(until, lambda why: f"cannot listen: {why}"))
    assert code == (failure is not None)
    assert message in capsys.readouterr().err
    assert signal.getsignal(signal.SIGTERM) is before
