"""The supervisor with processes that only say that they are stations."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from achse.fleet.plan import FleetPlan
from achse.fleet.supervisor import FleetSupervisor, usable_cores
from achse.station.configuration.types import ConfigError

ACTOR = """
import json, sys
print("not JSON")
for number in map(int, sys.argv[1:]):
    print(json.dumps({"event": "ready", "station": number, "address": "here"}))
    figures = {"event": "figures", "station": number, "state": "RUN", "axes": 3, "online": True,
               "cycles": 2, "computed_s": 0.5, "partners": 7}
    print(json.dumps(figures), flush=True)
print("said", *sys.argv[1:], file=sys.stderr)
sys.stdin.read()
"""

ALL_READY = """
for number in (1, 2, 3):
    print('{"event": "ready", "station": %d}' % number, flush=True)
"""

ALL_READY = """
for number in (1, 2, 3):
    print('{"event": "ready", "station": %d}' % number, flush=True)
"""


def plan_of(folder: Path, more: str = "") -> FleetPlan:
    (folder / "t.toml").write_text("")
    (folder / "fleet.toml").write_text(
        f'template = "t.toml"\ncount = 3\nnet_id = "5.1.1.1.1.1"\n{more}\n'
        '[mqtt]\nbroker = "b"\ntopic = "t"\n'
    )
    return FleetPlan.load(folder / "fleet.toml")


def actor(numbers: Sequence[int], core: int | None) -> list[str]:
    return [sys.executable, "-c", ACTOR, *map(str, numbers)]


@asynccontextmanager
async def running(
    plan: FleetPlan,
    folder: Path,
    command: Callable[[Sequence[int], int | None], list[str]] = actor,
) -> AsyncIterator[FleetSupervisor]:
    supervisor = FleetSupervisor(plan, command, folder / "logs")
    task = asyncio.create_task(supervisor.run())
    try:
        await supervisor.ready()
        yield supervisor
    finally:
        supervisor.stop()
        await task
    assert {row["state"] for row in supervisor.rows()} <= {"ended", "failed"}
    children = [each.child for each in supervisor.processes if each.child is not None]
    assert all(child.returncode is not None for child in children)


async def until(condition: Callable[[], object]) -> None:
    loop = asyncio.get_running_loop()
    while not condition():
        turn = loop.create_future()
        loop.call_soon(turn.set_result, None)
        await turn


async def test_stations_are_started_shown_and_ended(tmp_path: Path) -> None:
    async with running(plan_of(tmp_path, "stations_per_process = 2"), tmp_path) as supervisor:
        await until(lambda: all(row["axes"] == 3 for row in supervisor.rows()))
        rows = supervisor.rows()
        assert [row["station"] for row in rows] == [1, 2, 3]
        assert [row["process"] for row in rows] == [1, 1, 2]
        assert rows[0]["pid"] == rows[1]["pid"] != rows[2]["pid"]
        assert {row["state"] for row in rows} == {"RUN"}
        assert {row["cycle_s"] for row in rows} == {0.25}
        log = supervisor.log_of(3)
        await until(lambda: log.read_text() == "said 3\n")


async def test_a_killed_one_is_started_again(tmp_path: Path) -> None:
    async with running(plan_of(tmp_path), tmp_path) as supervisor:
        before = [row["pid"] for row in supervisor.rows()]
        os.kill(before[1], signal.SIGKILL)
        await until(lambda: supervisor.rows()[1]["pid"] not in (None, before[1]))
        await until(lambda: supervisor.rows()[1]["state"] == "RUN")
        rows = supervisor.rows()
        assert [row["restarts"] for row in rows] == [0, 1, 0]
        assert [rows[0]["pid"], rows[2]["pid"]] == [before[0], before[2]]


async def test_restarts_have_an_end_and_an_order_begins_again(tmp_path: Path) -> None:
    async with running(plan_of(tmp_path, "restarts = 0"), tmp_path) as supervisor:
        os.kill(supervisor.rows()[0]["pid"], signal.SIGKILL)
        await until(lambda: supervisor.rows()[0]["state"] == "failed")
        assert await supervisor.restart([1]) == [1]
        await until(lambda: supervisor.rows()[0]["state"] == "RUN")


async def test_an_ordered_restart_takes_the_whole_process(tmp_path: Path) -> None:
    async with running(plan_of(tmp_path, "stations_per_process = 2"), tmp_path) as supervisor:
        before = [row["pid"] for row in supervisor.rows()]
        assert await supervisor.restart([2]) == [1, 2]
        after = [row["pid"] for row in supervisor.rows()]
        assert before[0] not in after
        assert before[2] == after[2]
        assert await supervisor.restart() == [1, 2, 3]
        assert {row["restarts"] for row in supervisor.rows()} == {0}


@pytest.mark.parametrize(
    "words", [[sys.executable, "-c", "raise SystemExit(1)"], ["/does/not/exist"]]
)
async def test_what_never_was_ready_is_not_started_again(tmp_path: Path, words: list[str]) -> None:
    async with running(plan_of(tmp_path), tmp_path, lambda numbers, core: words) as supervisor:
        rows = supervisor.rows()
        assert {row["state"] for row in rows} == {"failed"}
        assert {row["pid"] for row in rows} == {None}


async def test_a_silent_one_is_shown_as_silent(tmp_path: Path) -> None:
    now = 0.0
    plan = plan_of(tmp_path)
    supervisor = FleetSupervisor(plan, actor, tmp_path / "logs", clock=lambda: now)
    task = asyncio.create_task(supervisor.run())
    await until(lambda: all(row["state"] == "RUN" for row in supervisor.rows()))
    now = 100.0
    assert {row["state"] for row in supervisor.rows()} == {"silent"}
    supervisor.stop()
    await task


async def test_one_that_hangs_is_killed_and_started_again(tmp_path: Path) -> None:
    """The actor says nothing after its first words."""
    plan = plan_of(tmp_path, "stations_per_process = 3")
    supervisor = FleetSupervisor(plan, actor, tmp_path / "logs", look_s=0.01)
    task = asyncio.create_task(supervisor.run())
    await until(lambda: supervisor.rows()[0]["restarts"] >= 2)
    supervisor.stop()
    await task


async def test_no_line_is_lost_while_a_log_is_shortened(tmp_path: Path) -> None:
    """The process writes all the time, 12 MB of numbered lines."""
    wordy = (
        "import sys\n"
        'print(\'{"event": "ready", "station": 1}\', flush=True)\n'
        "for number in range(120_000): sys.stderr.write(f'{number:099d}' + chr(10))\n"
        "sys.stderr.flush()\n"
        "sys.stdin.read()\n"
        "sys.stderr.write('further')"
    )
    command = [sys.executable, "-c", wordy]
    supervisor = FleetSupervisor(plan_of(tmp_path), lambda numbers, core: command, tmp_path)
    task = asyncio.create_task(supervisor.run())
    log = supervisor.log_of(1)
    await until(lambda: log.exists() and _last_line(log) == b"%099d" % 119_999)
    supervisor.stop()
    await task
    *lines, last = log.read_text().splitlines()
    assert last == "further"
    assert [int(line) for line in lines] == list(range(120_000 - len(lines), 120_000))
    assert len(lines) > 10_000


def _last_line(log: Path) -> bytes:
    with log.open("rb") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - 100, 0))
        return file.read().strip()


@pytest.mark.skipif(sys.platform == "win32", reason="no file descriptors are passed on")
async def test_a_process_that_ends_leaves_a_child_with_its_stderr(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is started again nevertheless, and what its child writes comes into the log."""
    monkeypatch.setattr("achse.fleet.supervisor._LAST_LINES_S", 0.01)
    child = "import os, sys; os.read(int(sys.argv[1]), 1); sys.stderr.write('child' + chr(10))"
    parent = (
        "import os, subprocess, sys\n"
        "end, _ = os.pipe()  # ends with the parent\n"
        f"command = [sys.executable, '-c', {child!r}, str(end)]\n"
        "null = subprocess.DEVNULL\n"
        "subprocess.Popen(command, stdin=null, stdout=null, pass_fds=[end])\n"
        f"{ALL_READY}"
    )
    command = [sys.executable, "-c", parent]
    plan = plan_of(tmp_path, "stations_per_process = 3\nrestarts = 1")
    supervisor = FleetSupervisor(plan, lambda numbers, core: command, tmp_path)
    task = asyncio.create_task(supervisor.run())
    log = supervisor.log_of(1)
    await until(lambda: log.exists() and log.read_text() == "child\nchild\n")
    supervisor.stop()
    await task


@pytest.mark.skipif(sys.platform == "win32", reason="it is ended by a signal")
async def test_a_process_goes_on_without_the_reader_of_its_log(tmp_path: Path) -> None:
    """The supervisor is killed: its station ends in order, though nobody reads what it writes."""
    done = tmp_path / "done"
    wordy = (
        "import sys, pathlib\n"
        f"{ALL_READY}"
        "sys.stdin.read()\n"
        "try:\n"
        "    for _ in range(10_000): sys.stderr.write('x' * 99 + chr(10))\n"
        "except OSError: pass\n"
        f"pathlib.Path({str(done)!r}).touch()\n"
    )
    script = (
        "import asyncio, sys\nfrom pathlib import Path\n"
        "from achse.fleet.plan import FleetPlan\n"
        "from achse.fleet.supervisor import FleetSupervisor\n"
        "async def main():\n"
        f"    plan = FleetPlan.load({str(tmp_path / 'fleet.toml')!r})\n"
        f"    command = lambda numbers, core: [sys.executable, '-c', {wordy!r}]\n"
        f"    supervisor = FleetSupervisor(plan, command, Path({str(tmp_path)!r}))\n"
        "    task = asyncio.create_task(supervisor.run())\n"
        "    await supervisor.processes[0].ready.wait()\n"
        "    print('ready', flush=True)\n"
        "    await task\n"
        "asyncio.run(main())\n"
    )
    plan_of(tmp_path, "stations_per_process = 3")
    supervisor = await asyncio.create_subprocess_exec(
        sys.executable, "-c", script, stdout=asyncio.subprocess.PIPE
    )
    assert supervisor.stdout is not None
    assert await supervisor.stdout.readline() == b"ready\n"
    supervisor.kill()
    await supervisor.wait()
    await until(done.exists)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux pins processes to cores")
def test_cores(tmp_path: Path) -> None:
    ours = sorted(os.sched_getaffinity(0))
    assert usable_cores(plan_of(tmp_path)) == ours
    assert usable_cores(plan_of(tmp_path, 'cores = "none"')) == []
    assert usable_cores(plan_of(tmp_path, f"cores = [{ours[-1]}]")) == [ours[-1]]
    with pytest.raises(ConfigError, match=r"fleet.toml:4: cores: there are .*, got 9999"):
        usable_cores(plan_of(tmp_path, "cores = [9999]"))
