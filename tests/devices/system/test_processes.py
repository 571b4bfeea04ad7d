"""Start process: the programs that the user allows, and no others."""

import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.devices.system.processes import MOST_PROCESSES, Processes
from achse.server import IndexGroup

START = 500
HIDDEN = 0x1_0000
ROOT = Path(Path.cwd().anchor)
"""`/`, or the drive."""


class Started:
    """A process that ends when the test says so."""

    code: int | None = None

    def poll(self) -> int | None:
        return self.code


class Host:
    """Notes what is started; programs with these names are not there."""

    def __init__(self, *programs: str, missing: Sequence[str] = ()) -> None:
        self.started: list[tuple[Sequence[str], str | None]] = []
        self.running: list[Started] = []
        self._missing = missing
        self.processes = Processes(programs, lambda _, __, job: job(), self._spawn)
        (self.group,) = cast("Sequence[IndexGroup]", list(self.processes.groups()))

    def _spawn(self, arguments: Sequence[str], folder: str | None) -> "subprocess.Popen[bytes]":
        if arguments[0] in self._missing:
            raise FileNotFoundError(2, "No such file", arguments[0])
        self.started.append((arguments, folder))
        self.running.append(Started())
        return cast("subprocess.Popen[bytes]", self.running[-1])

    def start(self, program: str, line: str = "", folder: str = "", offset: int = 0) -> None:
        self.group.write(START, offset, _request(program, folder, line), b"")


def _request(*texts: str) -> bytes:
    """Program, folder and command line as they travel."""
    raw = [text.encode() for text in texts]
    return struct.pack("<3I", *map(len, raw)) + b"".join(text + b"\0" for text in raw)


TOOL = str(ROOT / "opt" / "press" / "tool")


def test_station_without_programs_supports_no_start(client: Any, refused: Any) -> None:
    with refused(0x701):
        client.write(START, 0, _request(sys.executable, "", ""))


def test_allowed_program_starts_with_arguments_and_folder() -> None:
    host = Host(TOOL)
    host.start(TOOL, "-v 'two words' > file", "/srv", HIDDEN)
    host.start(TOOL)
    assert host.started == [([TOOL, "-v", "two words", ">", "file"], "/srv"), ([TOOL], None)]


@settings(max_examples=60, deadline=None)
@given(
    parts=st.lists(
        st.sampled_from(["opt", "press", "tool", "tool7", "..", ".", "*", "\x7f"]), max_size=4
    ),
    absolute=st.booleans(),
    line=st.sampled_from(["", "a", "; rm", "$(x)"]),
)
def test_only_paths_of_a_pattern_start(parts: list[str], absolute: bool, line: str) -> None:
    """`*` is for one name: it reaches neither another folder nor one above."""
    host = Host(str(ROOT / "opt" / "*" / "tool?"), str(ROOT / "opt" / "tool"))
    program = (str(ROOT) if absolute else "") + "/".join(parts)
    names = [part for part in parts if part != "."]
    allowed = absolute and (
        names == ["opt", "tool"] or (len(names) == 3 and names[0] == "opt" and names[2] == "tool7")
    )
    allowed = allowed and ".." not in names
    try:
        host.start(program, line)
    except DeviceError as refusal:
        code = refusal.code
    else:
        code = 0
    assert (code, len(host.started)) == ((0, 1) if allowed else (0x723, 0))


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", 0x705),
        (struct.pack("<3I", 0, 0, 0), 0x705),
        (struct.pack("<3I", 1 << 31, 1 << 31, 1 << 31), 0x705),
        (_request(TOOL, "", "") + b"x", 0x705),
        (struct.pack("<3I", 1, 1, 1) + b"abcdef", 0x706),
        (struct.pack("<3I", 2, 0, 0) + b"a\0\0\0\0", 0x706),
        (_request(TOOL, "", "'"), 0x70D),
        (_request(TOOL + "2", "", ""), 0x70C),
    ],
)
def test_request_that_cannot_be_served_is_refused(data: bytes, code: int, refused: Any) -> None:
    host = Host(TOOL, TOOL + "2", missing=[TOOL + "2"])
    with refused(code):
        host.group.write(START, 0, data, b"")
    with refused(0x703):
        host.start(TOOL, offset=1)
    assert host.started == []


def test_ended_processes_make_room(refused: Any) -> None:
    host = Host(TOOL)
    for _ in range(MOST_PROCESSES):
        host.start(TOOL)
    with refused(0x708):
        host.start(TOOL)
    host.running[3].code = 1
    host.processes.sweep()
    host.start(TOOL)
    with refused(0x708):
        host.start(TOOL)


@pytest.mark.skipif(sys.platform == "win32", reason="a file without format is a script on POSIX")
def test_program_of_the_computer_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An executable text without `#!` runs too, in the folder that was named."""
    script = tmp_path / "start.sh"
    script.write_text('printf %s "$1" >result')
    script.chmod(0o700)
    running: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    def keep(*arguments: Any, **options: Any) -> "subprocess.Popen[bytes]":
        running.append(popen(*arguments, **options))
        return running[-1]

    monkeypatch.setattr(subprocess, "Popen", keep)
    processes = Processes([str(script)], lambda _, __, job: job())
    (group,) = processes.groups()
    group.write(START, 0, _request(str(script), str(tmp_path), "'a b'"), b"")
    assert running[0].wait() == 0
    assert (tmp_path / "result").read_text() == "a b"
    processes.sweep()


def test_processes_at_most_when_started_from_several_threads() -> None:
    host, within, go_on = Host(TOOL), threading.Event(), threading.Event()
    for _ in range(MOST_PROCESSES - 1):
        host.start(TOOL)
    spawn = host.processes._spawn

    def slowly(arguments: Sequence[str], folder: str | None) -> "subprocess.Popen[bytes]":
        within.set()
        go_on.wait()
        return spawn(arguments, folder)

    host.processes._spawn = slowly
    codes: list[int] = []

    def start() -> None:
        try:
            host.start(TOOL)
        except DeviceError as refusal:
            codes.append(refusal.code)

    threads = [threading.Thread(target=start) for _ in range(3)]
    threads[0].start()
    within.wait()
    for each in threads[1:]:
        each.start()
    go_on.set()
    for each in threads:
        each.join()
    assert len(host.started) == MOST_PROCESSES
    assert codes == [0x708, 0x708]
