"""Processes below a process, and their CPU time (Linux: elsewhere there seem to be none)."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

__all__ = ["cpu_seconds_of", "processes_below"]


def processes_below(process: int) -> Iterator[int]:
    """Yield the children of a process that run, with their children."""
    for children in Path("/proc", str(process), "task").glob("*/children"):
        with contextlib.suppress(OSError):
            for child in map(int, children.read_text().split()):
                yield child
                yield from processes_below(child)


def cpu_seconds_of(process: int) -> float:
    """Return the CPU time of a process and of its children that ended, s; 0 if it is gone."""
    with contextlib.suppress(OSError):
        fields = Path("/proc", str(process), "stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    return 0.0
