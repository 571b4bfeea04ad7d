"""Two ends of a cable in a network namespace: slaves on one, a foreign master on the other."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
MASTER_END, SLAVE_END = "cable0", "cable1"
AS_ROOT = ["unshare", "--net"]
AS_USER = ["unshare", "--map-root-user", "--net"]

CABLE = (
    f"ip link add {MASTER_END} type veth peer name {SLAVE_END}"
    f" && ip link set {MASTER_END} up && ip link set {SLAVE_END} up && ip link set lo up"
)


REAL_TIME, FIRST = ("chrt", "--fifo", "40"), ("chrt", "--fifo", "50")
"""Masters have time-outs of milliseconds, and other tests run on the same cores. The slaves run at
their own, higher real-time priority."""


def _report_in(out: str) -> Any:
    """The line of JSON, wherever the buffers of a library put it among its own lines."""
    return json.loads(
        next(line for line in reversed(out.splitlines()) if line.startswith(("{", "[")))
    )


class Bus:
    """A namespace with a cable; `slaves` runs at one end, `master` runs at the other.

    `prompt` is the command that runs another in real time, empty where that is not allowed, and
    `first` the one before it, for slaves; `achse` is the quick command.
    """

    def __init__(
        self, unshare: list[str], prompt: tuple[str, ...], achse: Path, tmp_path: Path
    ) -> None:
        self._unshare = unshare
        self.achse = achse
        self._prompt = prompt
        self.first = FIRST if prompt else ()
        self._holder: subprocess.Popen[str] | None = None
        self._recorder: subprocess.Popen[str] | None = None
        self.capture = tmp_path / "bus.pcap"

    def slaves(self, script: str, *arguments: object) -> None:
        """Start a script as the slaves' side and wait until it is ready."""
        assert self.serve(sys.executable, HERE / script, SLAVE_END, *arguments) == "ready\n"

    def drives(self, *options: object) -> str:
        """Let `achse drive serve` be the slaves' side; its ready line."""
        command = ("drive", "serve", "--interface", SLAVE_END)
        return self.serve(self.achse, *command, *options)

    def serve(self, *command: object) -> str:
        """Start the slaves' side; the line it prints when it is ready."""
        self._holder = subprocess.Popen(
            [*self._unshare, *("sh", "-c", f'{CABLE} && exec "$@"', "sh"), *map(str, command)],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._holder.stdout is not None
        return self._holder.stdout.readline()

    def record(self) -> None:
        """Write what passes the master's end to `capture` from now on."""
        self._recorder = subprocess.Popen(
            [
                *self._inside(),
                *(sys.executable, str(HERE / "recorder.py"), MASTER_END, str(self.capture)),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._recorder.stdout is not None
        assert self._recorder.stdout.readline() == "ready\n"

    def end_record(self) -> None:
        """The capture is complete."""
        if self._recorder is not None:
            self._recorder.terminate()
            self._recorder.communicate()
            self._recorder = None

    def master(self, script: str, *arguments: object) -> Any:
        """Run a script of masters/ and give what it found."""
        command = self._command(script, *arguments)
        return _report_in(self.run(*self._prompt, *command))

    @contextlib.contextmanager
    def beside(self, script: str, *arguments: object, ready: str) -> Iterator[dict[str, Any]]:
        """While a script of masters/ runs, from when it says `ready` on stderr; what it found."""
        command = self._command(script, *arguments)
        report: dict[str, Any] = {}
        with subprocess.Popen(
            [*self._inside(), *self._prompt, *map(str, command)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as master:
            assert master.stderr is not None
            assert master.stderr.readline() == f"{ready}\n"
            yield report
            out, errors = master.communicate()
        assert master.returncode == 0, errors + out
        report.update(_report_in(out))

    def run(self, *command: object) -> str:
        """Run a command beside the slaves; what it printed."""
        finished = subprocess.run(
            [*self._inside(), *map(str, command)], capture_output=True, text=True
        )
        assert finished.returncode == 0, finished.stderr + finished.stdout
        return finished.stdout

    def _command(self, script: str, *arguments: object) -> tuple[object, ...]:
        """A script of masters/, which is told its interface and its reply timeout in ms."""
        # Slaves that take most of a processor wait for theirs like everyone else. KickCAT waits as
        # long for frames that it does not miss.
        timeout = 1000 if script.startswith("pysoem") else 15 if self._prompt else 50
        return (sys.executable, HERE / "masters" / script, MASTER_END, timeout, *arguments)

    def _inside(self) -> list[str]:
        assert self._holder is not None
        enter = ["nsenter", "--net", "--target", str(self._holder.pid)]
        if "--map-root-user" in self._unshare:
            enter += ["--user", "--preserve-credentials"]
        return enter

    def end(self) -> None:
        """Stop the slaves; they must leave in peace."""
        self.end_record()
        if self._holder is not None:
            with self._holder:  # closes the pipe
                self._holder.terminate()
                assert self._holder.wait() == 0


@pytest.fixture(scope="session")
def unshare() -> list[str]:
    """The command that runs another in a network namespace of its own; skips where forbidden."""
    if not (shutil.which("unshare") and shutil.which("nsenter") and shutil.which("ip")):
        pytest.skip("no unshare, nsenter or ip on this machine")
    command = AS_ROOT if os.geteuid() == 0 else AS_USER
    run = subprocess.run([*command, "sh", "-c", CABLE], capture_output=True, text=True)
    if run.returncode:
        pytest.skip(f"network namespaces are forbidden here: {run.stderr.strip()}")
    return command


@pytest.fixture(scope="session")
def prompt() -> tuple[str, ...]:
    """The command that runs a master in real time; empty where that is not allowed."""
    allowed = shutil.which("chrt") and not subprocess.run([*REAL_TIME, "true"]).returncode
    return REAL_TIME if allowed else ()


@pytest.fixture
def bus(
    unshare: list[str], prompt: tuple[str, ...], warm_commands: Any, tmp_path: Path
) -> Iterator[Bus]:
    """A cable in a namespace of its own."""
    line = Bus(unshare, prompt, warm_commands.folder / "achse", tmp_path)
    try:
        yield line
    finally:
        line.end()


FRAME_FIELDS = ("-e", "frame.protocols", "-e", "_ws.malformed", "-e", "_ws.expert.severity")

EXPERT_ERROR = 0x800000
"""Severity from which on tshark means an error."""


@pytest.fixture
def judge(witness: Callable[[str], None]) -> Callable[[Path], int]:
    """`judge(capture)` lets tshark read a capture: no malformed frame, no error; frames read."""
    witness("tshark")

    def read(capture: Path) -> int:
        words = ["tshark", "-r", str(capture), "-T", "fields", *FRAME_FIELDS]
        run = subprocess.run(words, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        frames = [line.split("\t") for line in run.stdout.splitlines()]
        for number, (protocols, malformed, severities) in enumerate(frames, 1):
            worst = max((int(each, 0) for each in severities.split(",") if each), default=0)
            assert not malformed, number
            assert worst < EXPERT_ERROR, number
            assert "ecat" in protocols, number
        return len(frames)

    return read
