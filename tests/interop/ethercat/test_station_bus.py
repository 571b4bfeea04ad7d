"""A station with its bus on an interface, slaves of another process at the other end of a cable."""

import contextlib
import os
import re
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

NOBODY = "trap 'kill $!; exit 0' TERM; echo ready; sleep 1000 & wait"
"""Holds the namespace; the slaves are started inside it."""

ROOT = Path(__file__).parents[3]
TRIES = 3
"""A machine that is busy for longer than the watchdogs is an axis error too, as documented."""

INVALID, NOT_READY = 0x4655, 0x4650


def test_whatever_breaks_is_an_axis_error_over_ads_and_recovers(bus: Any) -> None:
    bus.serve("sh", "-c", NOBODY)
    report = bus.master("achse_station.py")
    assert report["echo"], "terminals share the bus"
    assert report["cable"] == {"errors": [INVALID, INVALID], "recovered": True}
    assert report["killed"] == {"errors": [INVALID, INVALID], "recovered": True}
    assert report["safeop"]["errors"][0] == INVALID
    assert report["alarm"]["errors"][0] == NOT_READY
    assert report["safeop"]["recovered"]
    assert report["alarm"]["recovered"]
    assert report["statistics"]["round_trips"] > 0
    assert report["statistics"]["trouble"] == ""


def test_a_cut_cable_of_a_line_between_two_interfaces_stops_no_axis(bus: Any) -> None:
    bus.serve("sh", "-c", NOBODY)
    report = bus.master("achse_ring.py")
    first, second = (
        {"state": state, "opening": opening, "moved": True, "errors": [0, 0]}
        for state, opening in (
            (0x0009, "between the first adapter and Drive 1 (axis 1)"),
            (0x000C, "between Drive 2 (axis 2) and the second adapter"),
        )
    )
    assert [report[end] for end in ("cable1", "cable0", "cable3", "cable2")] == [first] * 2 + [
        second
    ] * 2
    assert report["both"] == {"errors": [INVALID, INVALID], "recovered": True}
    statistics = report["statistics"]
    assert (statistics["interface"], statistics["second_interface"]) == ("cable0", "cable2")
    assert (statistics["trouble"], statistics["ring_open"]) == ("", "")


ONE_CABLE = (
    "OP; no fault",
    "cable0: complete",
    "X: 0.000 → 50.0",
    "0x4655",
)
TWO_CABLES = (
    "OP; no fault",
    "OP; link error, ring is open",
    "cable0, cable2: complete",
    "the ring is open between the first adapter and Drive 1 (axis X)",
    "X: 0.000 → 50.0",
    "→ 100.0",
    "0x4655",
)


@pytest.mark.parametrize(("number", "shown"), [(0, ONE_CABLE), (1, TWO_CABLES)])
def test_the_commands_of_the_how_to(
    unshare: list[str], warm_commands: Any, number: int, shown: tuple[str, ...], tmp_path: Path
) -> None:
    page = (ROOT / "docs" / "how-to" / "put-axes-on-drives.md").read_text(encoding="utf-8")
    block = re.findall(r"^```sh\n(.*?)^```", page, re.MULTILINE | re.DOTALL)[number]
    first, commands = block.split("\n", 1)
    assert first == "unshare --net bash"
    environment = os.environ | {
        "PATH": warm_commands.path(),
        "ACHSE_RUNTIME_DIR": str(tmp_path / "run"),
    }
    for _ in range(TRIES):
        with (tmp_path / "printed").open("w+", encoding="utf-8") as file:
            shell = subprocess.Popen(
                [*unshare, "bash", "-e", "-c", commands],
                stdout=file,
                stderr=subprocess.STDOUT,
                cwd=ROOT,
                env=environment,
                start_new_session=True,
            )
            shell.wait()
            file.seek(0)
            printed = file.read()
        if shell.returncode == 0:
            break
        # What the shell had started still runs.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)
        subprocess.run(
            [warm_commands.folder / "achse", "stop", "--all"], env=environment, capture_output=True
        )
    assert shell.returncode == 0, printed
    for message in shown:
        assert message in printed
    assert "→ 0.0" in printed or "→ -0.0" in printed
