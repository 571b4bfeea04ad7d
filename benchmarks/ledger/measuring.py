"""Measure works: run them under Callgrind in processes of their own and read what was counted.

Warm works share a process, each cold one has its own; `counted.py` is that process. Figures repeat
to 1 % on a busy machine because nothing in them depends on the moment or the machine: hashes have a
fixed seed, addresses are not random, machine code is for one processor, the search for garbage is
off while warm works are counted, byte code and machine code are in caches, and no work waits for
the clock.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from counting import is_supported
from works import WORKS, Work

__all__ = [
    "Figures",
    "LedgerUnavailable",
    "Outcome",
    "check_available",
    "groups_of",
    "measure",
    "outcomes",
]

ROOT = Path(__file__).parents[2]
_DUMP = re.compile(r"^desc: Trigger: Client Request: (.+?)$.*?^totals: (\d+)$", re.M | re.S)


class LedgerUnavailable(Exception):
    """Nothing can be counted here; says what is missing."""


class Figures(NamedTuple):
    """Instructions and allocations of one repetition of a work."""

    instructions: int
    allocations: float


Outcome = Figures | str
"""Figures of a work, or why there are none."""


def check_available() -> None:
    """Raise LedgerUnavailable unless works can be counted on this machine."""
    if not is_supported():
        raise LedgerUnavailable("expected CPython on Linux, x86-64")
    if shutil.which("valgrind") is None:
        raise LedgerUnavailable("valgrind not found (apt-get install valgrind)")


def measure(works: Sequence[Work] = WORKS, source: Path = ROOT) -> dict[str, Outcome]:
    """Return the outcome of works by name, for the tree at `source`."""
    check_available()
    groups = groups_of(works)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runner = _Runner(folder, _environment(source))
        runner.run("native", [work for group in groups for work in group])  # fills the caches
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            outcomes = dict(
                pair for each in pool.map(runner.count, groups) for pair in each.items()
            )
    return {work.name: outcomes[work.name] for work in works}


def groups_of(works: Iterable[Work]) -> list[list[Work]]:
    """Return the works of each process, the longest first.

    Warm works always run together: CPython specialises byte code for all of them, so that one
    alone takes up to 10 % less.
    """
    chosen = list(works)
    cold = [[work] for work in reversed(chosen) if not work.repetitions]
    warm = [work for work in WORKS if work.repetitions]
    return [*cold, warm] if any(work.repetitions for work in chosen) else cold


def outcomes(
    works: Iterable[Work], instructions: Mapping[str, int], lines: Iterable[str]
) -> dict[str, Outcome]:
    """Return outcomes by name from the totals of dumps and the lines that `counted.py` wrote."""
    results = dict(line.rstrip("\n").split("\t", 1) for line in lines)
    by_name: dict[str, Outcome] = {}
    for work in works:
        result = results[work.place]
        if not result.isdigit():
            by_name[work.name] = result
            continue
        many, few = (
            instructions[f"{work.place}/{runs}"]
            for runs in (2 * work.repetitions or 1, work.repetitions)
        )
        repetitions = work.repetitions or 1
        by_name[work.name] = Figures(
            round((many - few) / repetitions), round(int(result) / repetitions, 2)
        )
    return by_name


class _Runner:
    """Processes of `counted.py` in a folder, whose name none of them sees: it is random."""

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder
        self._environment = environment
        self._prefix = _fixed_addresses()

    def run(
        self, name: str, works: Iterable[Work], prefix: Sequence[str] = ()
    ) -> "subprocess.CompletedProcess[str]":
        """Run works in a process; their lines are in the file `name`."""
        child = [sys.executable, str(Path(__file__).with_name("counted.py"))]
        return subprocess.run(
            [*prefix, *child, name, *(work.place for work in works)], cwd=self._folder,
            env=self._environment, capture_output=True, text=True, check=False,
        )  # fmt: skip

    def count(self, works: Sequence[Work]) -> dict[str, Outcome]:
        """Run works in a process under Callgrind; return their outcomes by name."""
        name = works[0].place
        dumps = f"dump {name}"
        valgrind = [
            *("valgrind", "-q", "--tool=callgrind", "--instr-atstart=no"),
            f"--callgrind-out-file={dumps}",
        ]
        ended = self.run(name, works, [*self._prefix, *valgrind])
        results = self._folder / name
        if ended.returncode or not results.exists():
            lines = (ended.stderr.strip() or f"ended with {ended.returncode}").splitlines()
            return {work.name: lines[-1] for work in works}
        instructions: dict[str, int] = {}
        for dump in self._folder.glob(f"{dumps}*"):
            if match := _DUMP.search(dump.read_text(errors="replace")):
                instructions[match[1]] = int(match[2])
        return outcomes(works, instructions, results.read_text(encoding="utf-8").splitlines())


def _environment(source: Path) -> dict[str, str]:
    """Return the environment of works; their machine code has a cache of its own."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return {
        "ACHSE_CACHE_DIR": str(cache / "achse-ledger"),
        "COLUMNS": "100",
        "HOME": ".",
        "LC_ALL": "C.UTF-8",
        "PATH": os.environ["PATH"],
        "PYTHONHASHSEED": "0",
        "PYTHONPATH": str(source / "src"),
    }


def _fixed_addresses() -> list[str]:
    """Return a prefix that runs a command without random addresses, if that is allowed here."""
    prefix = ["setarch", "-R"]
    try:
        allowed = subprocess.run([*prefix, "true"], capture_output=True, check=False)
    except FileNotFoundError:
        return []
    return prefix if allowed.returncode == 0 else []
