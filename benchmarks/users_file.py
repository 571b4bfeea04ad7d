"""How long a user's pytest run takes: fifteen lines with our fixture, beside pyads' test server.

Ours meets an error code, a stale handle and a restart, theirs reads one variable. Both are a
`pytest -q` of their own; the median of several runs in turns is printed, with what of it was the
processor's, and the time in which a station in virtual time stands ready, imports not counted.
Usage: python benchmarks/users_file.py [RUNS]
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from processes import HERE

from achse.testing import LiveStation, free_host

OURS = (HERE.parent / "tests" / "data" / "fifteen_lines.txt").read_text()
THEIRS = """\
import socket
import time

import pyads
import pytest
from pyads.testserver import AdsTestServer, AdvancedHandler, PLCVariable

@pytest.fixture
def server():
    handler = AdvancedHandler()
    handler.add_variable(PLCVariable("GVL.nInt", bytes(2), ads_type=2, symbol_type="INT"))
    with AdsTestServer(handler, ip_address="HOST", logging=False):
        for _ in range(200):  # it does not say when it listens
            with socket.socket() as knock:
                if knock.connect_ex(("HOST", 48898)) == 0:
                    break
            time.sleep(0.01)
        yield

def test_one_read(server):
    pyads.open_port()
    pyads.set_local_address("192.0.2.77.1.1")
    pyads.add_route("HOST.1.1", "HOST")
    with pyads.Connection("HOST.1.1", 851, "HOST") as plc:
        assert plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT) == 0
"""


def run(folder: Path, text: str) -> tuple[float, float]:
    """Seconds and seconds of processor of a pytest run over a folder with this file only."""
    (folder / "test_ours.py").write_text(text)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before = os.times()
    command = [sys.executable, "-m", "pytest", "-q", str(folder)]
    finished = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    after = os.times()
    if "1 passed" not in finished.stdout:
        raise SystemExit(finished.stdout + finished.stderr)
    worked = after.children_user + after.children_system
    return after.elapsed - before.elapsed, worked - before.children_user - before.children_system


def ready() -> float:
    """Seconds until a station in virtual time answers."""
    begin = time.perf_counter()
    with LiveStation(time="virtual"):
        return time.perf_counter() - begin


def main(runs: int) -> None:
    print(f"median of {runs} runs in turns, after one that warms the caches")
    with tempfile.TemporaryDirectory() as ours, tempfile.TemporaryDirectory() as theirs:
        sides = {
            "achse_station, 15 lines": (ours, OURS),
            "pyads' test server": (theirs, THEIRS.replace("HOST", free_host())),
        }
        taken = {name: [run(Path(folder), text)] for name, (folder, text) in sides.items()}
        for _ in range(runs):
            for name, (folder, text) in sides.items():
                taken[name].append(run(Path(folder), text))
    for name, pairs in taken.items():
        whole, worked = (statistics.median(each) for each in zip(*pairs[1:], strict=True))
        budget = "budget 2.0" if "achse" in name else ""
        print(f"{name:26} {whole:5.2f} s, processor {worked:5.2f} s  {budget}")
    ready()
    best = min(ready() for _ in range(runs)) * 1e3
    print(f"{'ready in virtual time':26} {best:5.0f} ms  budget 300")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
