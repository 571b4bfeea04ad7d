"""How long a cold process takes: `import achse`, `achse --help`, `achse run` until it is ready.

Each is a fresh interpreter with warm file caches; the median of several runs is printed beside a
bare interpreter, which is part of every number. A single run warms no caches before.
Usage: python benchmarks/cold_start.py [RUNS]
"""

import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

PYTHON = sys.executable
WITHOUT_LLVMLITE = "import sys; sys.modules['llvmlite'] = None; import achse.cli; achse.cli.main()"
"""`achse` as if the extra `fast` were not installed."""


def until_exit(*arguments: str) -> float:
    """Seconds from start to exit."""
    start = time.perf_counter()
    subprocess.run([PYTHON, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def until_ready(*arguments: str) -> float:
    """Seconds from start to the ready line; the station is ended afterwards."""
    start = time.perf_counter()
    with subprocess.Popen(
        [PYTHON, *arguments, "run", "--tcp-port", "0"], stdout=subprocess.PIPE, text=True
    ) as station:
        assert station.stdout is not None
        line = station.stdout.readline()
        elapsed = time.perf_counter() - start
        station.send_signal(signal.SIGTERM)
    if not line.startswith("achse ready"):
        raise SystemExit(f"the station did not start: {line!r}")
    return elapsed


CASES: dict[str, tuple[Callable[[], float], float | None]] = {
    "bare interpreter": (lambda: until_exit("-c", "pass"), None),
    "import achse": (lambda: until_exit("-c", "import achse"), 30),
    "achse --help": (lambda: until_exit("-m", "achse", "--help"), 200),
    "station ready, without llvmlite": (lambda: until_ready("-c", WITHOUT_LLVMLITE), 400),
    "station ready, as installed": (lambda: until_ready("-m", "achse"), 500),
}
"""What is measured and its budget in ms."""


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 9
    print(f"median of {runs} runs after one that warms the caches; {os.cpu_count()} cores")
    for name, (measure, budget) in CASES.items():
        if runs > 1:
            measure()
        times = sorted(measure() * 1e3 for _ in range(runs))
        limit = f"budget {budget:4.0f}" if budget else ""
        print(f"{name:30} {statistics.median(times):6.0f} ms  best {times[0]:6.0f}  {limit}")


if __name__ == "__main__":
    main()
