"""`achse replay`, `achse diff`, and what `achse monitor` records for them."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import achse
from achse.testing import LiveStation, free_host
from tests.warm_commands import WarmCommands

Cli = Callable[..., Any]


def _start(commands: WarmCommands, *arguments: str) -> "subprocess.Popen[str]":
    process = commands.popen(*arguments, stdout=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdout.readline().startswith("achse ready ")
    return process


def _session(host: str, value: int) -> list[Any]:
    with achse.blocking.connect(host, watch_symbols=False) as plc:
        plc.write("GVL.nInt", value)
        return [plc.read("GVL.nInt"), plc.read("GVL.stPoint"), plc.device_info()]


def test_a_session_is_recorded_replayed_and_compared(
    tmp_path: Path, cli: Cli, warm_commands: WarmCommands
) -> None:
    files = [str(tmp_path / name) for name in ("one.pcapng", "two.pcapng")]
    with LiveStation() as station:
        for number, file in enumerate(files):
            recorder = _start(
                warm_commands, "monitor", "--write", file, "--quiet", "--host", station.host
            )
            captures = _session(station.host, number)
            recorder.terminate()
            out, _ = recorder.communicate()
            assert recorder.returncode == 0
            assert out.startswith(f"{file}: ")
    host = free_host()
    target = _start(warm_commands, "replay", files[1], "--host", host)
    try:
        assert _session(host, 1) == captures
    finally:
        target.terminate()
        target.communicate()
    assert target.returncode == 0
    assert cli("diff", files[0], files[0]).stdout == ""
    assert cli("diff", *files, exit_code=1).stdout.splitlines() == [
        "! 851 read GVL.nInt: 0 → 1",
        "! 851 write GVL.nInt: 0 → 1",
    ]


def test_what_is_no_capture_is_refused(tmp_path: Path, cli: Cli) -> None:
    text = tmp_path / "text"
    text.write_text("text")
    assert "neither pcapng nor pcap" in cli("replay", str(text), exit_code=1).stderr
    assert "No such file" in cli("replay", str(tmp_path / "nothing"), exit_code=1).stderr
    assert "no AMS packets" in cli("diff", *[_empty(tmp_path)] * 2, exit_code=2).stderr


def test_captures_are_compared_whatever_their_names_end_with(tmp_path: Path, cli: Cli) -> None:
    other = Path(_empty(tmp_path)).rename(tmp_path / "empty.cap")
    assert "no AMS packets" in cli("diff", str(other), str(other), exit_code=2).stderr


def _empty(folder: Path) -> str:
    from achse.monitor.capture import CaptureWriter

    path = folder / "empty.pcapng"
    with CaptureWriter(path):
        return str(path)
