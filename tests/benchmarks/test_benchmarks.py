"""Every benchmark runs: a short form of each ends with code 0 and prints what it measures."""

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"

PARTS = {"as_c.py", "mutant_rooms.py", "planter.py", "processes.py"}
"""What benchmarks share."""

NUMBER = r"[\d,]*\d\.?\d*"

SHORT: dict[str, tuple[list[str], str]] = {
    "agent_loop.py": (["12", "1"], rf"loop +p50 +{NUMBER} ms"),
    "bus_cycle.py": (["4", "20"], rf"achse, in memory, 4 drives +p50 +{NUMBER} µs"),
    "camshaft.py": (["2000"], rf"4 controllers of 128 cams at 1 ms: {NUMBER} s"),
    "cold_start.py": (["1"], rf"import achse +{NUMBER} ms"),
    "costs.py": (["0.05", "32"], rf"request by TCP +station +{NUMBER} µs"),
    "drawn_edits.py": (["12", "4", "1", "1"], "4 compared, 0 with other findings"),
    "driven_axes.py": (["0.1"], rf"4 axes on drives, kernel: +{NUMBER} × real time"),
    "ethercat_segment.py": (["0.01"], rf"32 +drives LRW\+FRMW +{NUMBER} +{NUMBER} +{NUMBER}"),
    "fleet.py": (["3", "10", "0.1", "3", "0.2"], r"[1-9]\d* writes acknowledged, 0 lost"),
    "forwarding.py": (["time", "2"], rf"routed +{NUMBER} µs per request and answer"),
    "frames.py": (["2000"], rf"64 per portion: +{NUMBER}/s  bare +{NUMBER}/s"),
    "gcode_parse.py": (["2000"], rf"parse +{NUMBER} blocks/s"),
    "language_server.py": (["12", "1"], rf"edit of a body, until shown +p50 +{NUMBER}"),
    "machine_code.py": (["70"], rf"FAST +compiled in +{NUMBER} ms, +{NUMBER} bytes"),
    "many_programs.py": (["1", "2", "1"], r"foreign( +0)+\n"),
    "mc_blocks.py": (["0.2", "1"], rf"so the PLC +{NUMBER}%, [1-9]\d* moves done"),
    "mutants.py": (
        ["counters", "--only", "ethercat/fmmu.py", "--count", "2"],
        r"counters +\d+ possible +2 planted +[12] killed",
    ),
    "nc_cycle.py": (["0.01", "100"], rf"255 +cams 100.* +{NUMBER} +{NUMBER} +{NUMBER} +{NUMBER}"),
    "nc_recorded.py": (["--hours", "0.05"], r"\d+ lines, \w+"),
    "outstanding.py": (["320", "1"], rf"achse station +{NUMBER} answers/s"),
    "own_coverage.py": (["codes"], rf"{NUMBER} % +\d+ statements  codes/ by its own tests"),
    "part_program.py": (["2000"], rf"whole way +{NUMBER} µs per block"),
    "path_blocks.py": (["2000"], rf"planning +{NUMBER} µs per block"),
    "planner.py": (["--cases", "50"], rf"any state +{NUMBER} +{NUMBER} +{NUMBER} +{NUMBER}"),
    "reads.py": (["50", "1"], rf"achse station +{NUMBER} reads/s +median latency +{NUMBER} µs"),
    "transports.py": (["50"], rf"TCP, achse +{NUMBER} +{NUMBER} µs +{NUMBER} answers/s"),
    "router_kills.py": (["1"], r"nothing left after \d+"),
    "same_run.py": (["--seconds", "10", "--turns", "30"], r"[1-9]\d* frames, \d+ lines, hash \w+"),
    "samples.py": (["20", "50", "0.3"], r"0 lost, 0\.000%"),
    "scope.py": (["1", "1000"], r"1 s of a station, 64 channels at 1 ms: .*, 0 samples lost"),
    "snapshots.py": (["0.03"], rf"255 axes +loop +{NUMBER} µs +thread +{NUMBER} µs"),
    "st_run.py": (["20", "0.05"], rf"plain +{NUMBER} ns per statement"),
    "st_parse.py": (["1000"], rf"lexer +{NUMBER} lines/s"),
    "sweeps.py": (["8", "1"], r"digests equal"),
    "soak.py": (["0.003"], r"digests equal"),
    "symbols_upload.py": (["500"], r"pyads get_all_symbols .*, 502 symbols"),
    "test_times.py": (["tests/ams/test_states.py"], rf"{NUMBER} s  the 1 quick files of this run"),
    "units.py": (["50"], r"digests equal"),
    "users_file.py": (["1"], rf"achse_station, 15 lines +{NUMBER} s, processor +{NUMBER} s"),
    "web.py": (["0.1", "2"], r"  2 pages  \d+ cycles, .*; [1-9]\d* blocks, [1-9]\d* rows read"),
    "virtual_time.py": (["0.1", "1"], rf"axes moving +{NUMBER} × real time"),
}
"""Arguments of about a second's work, and a line that it prints."""

ELSEWHERE = {
    "churn.py": "test_churn.py",
    "esi_devices.py": "test_esi_devices.py",
    "esi_line.py": "test_esi_devices.py",
    "ethercat_roundtrip.py": "needs a network namespace",
    "interface_bus.py": "needs a network namespace",
}

WITH_WITNESS = {
    "fleet.py": "mosquitto",
    "many_programs.py": "pyads",
    "reads.py": "pyads",
    "symbols_upload.py": "pyads",
    "units.py": "fmpy",
    "users_file.py": "pyads",
}


REAL = {"cold_start.py", "mutants.py", "own_coverage.py", "test_times.py"}
"""Benchmarks of starts, and those in whose process pytest runs: it loads its plugins itself."""

RunBenchmark = Callable[..., str]


@pytest.mark.parametrize("name", SHORT)
def test_a_benchmark_runs(
    witness: Callable[[str], None], run_benchmark: RunBenchmark, name: str
) -> None:
    if name in WITH_WITNESS:
        witness(WITH_WITNESS[name])
    if name == "planner.py":
        pytest.importorskip("ruckig")
    arguments, line = SHORT[name]
    printed = run_benchmark(name, *arguments, real=name in REAL)
    assert re.search(line, printed), printed


def test_drives_on_a_cable_beside_a_reflector(
    witness: Callable[[str], None], run_benchmark: RunBenchmark
) -> None:
    witness("pysoem")
    command = ["unshare", *(["--map-root-user"] if os.geteuid() else []), "--net", "true"]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("network namespaces are forbidden here")
    printed = run_benchmark("ethercat_roundtrip.py", "0.2", "1", real=True)
    assert re.search(rf"^ +1 +{NUMBER} +{NUMBER} +{NUMBER}", printed, re.MULTILINE), printed


def test_a_bus_on_an_interface_in_short(run_benchmark: RunBenchmark) -> None:
    if shutil.which("ip") is None or shutil.which("unshare") is None:
        pytest.skip("no ip or unshare on this machine")
    command = ["unshare", *(["--map-root-user"] if os.geteuid() else []), "--net", "true"]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("network namespaces are forbidden here")
    printed = run_benchmark(
        *("interface_bus.py", "--seconds", "0.1", "--drives", "2", "--cycle-us", "4000"), real=True
    )
    assert re.search(rf"achse station, 2 drives +{NUMBER} +{NUMBER} +{NUMBER}", printed), printed


def test_each_benchmark_has_its_short_form() -> None:
    there = {file.name for file in BENCHMARKS.glob("*.py")} - PARTS
    assert there == SHORT.keys() | ELSEWHERE.keys()
