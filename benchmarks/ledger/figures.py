"""The kept figures: lines of `figures.tsv`, the newest of a work and build last.

A line says what a work took at a commit, and why that differs from the line before. A commit with
"+" is the one after it: lines are added before the change is committed.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from measuring import Figures, Outcome

__all__ = ["GROWTH", "Finding", "Line", "append", "compare", "latest", "read"]

HEAD = ("build", "commit", "work", "instructions", "allocations", "reason")
GROWTH = 0.05
"""Growth since the newest line that needs a line of its own."""
_HALF = 0.5
"""Allocations that may come and go: a table that grows, once in many repetitions."""


class Line(NamedTuple):
    """One line."""

    build: str
    commit: str
    work: str
    figures: Figures
    reason: str


class Finding(NamedTuple):
    """What a comparison says of a work."""

    work: str
    text: str
    fails: bool


def read(file: Path) -> list[Line]:
    """Return the lines of a file; raises ValueError for a line that is none."""
    lines = []
    for number, text in enumerate(file.read_text(encoding="utf-8").splitlines()[1:], 2):
        cells = text.split("\t")
        if len(cells) != len(HEAD) or not cells[-1]:
            raise ValueError(f"{file.name}:{number}: expected {', '.join(HEAD)}, got {text!r}")
        build, commit, work, instructions, allocations, reason = cells
        figures = Figures(int(instructions), float(allocations))
        lines.append(Line(build, commit, work, figures, reason))
    return lines


def append(file: Path, lines: Iterable[Line]) -> None:
    """Add lines to a file, which is made if it is not there."""
    if not file.exists():
        file.write_text("\t".join(HEAD) + "\n", encoding="utf-8")
    with file.open("a", encoding="utf-8") as out:
        for line in lines:
            instructions, allocations = line.figures
            count = f"{allocations:.2f}".rstrip("0").rstrip(".")
            cells = (line.build, line.commit, line.work, instructions, count, line.reason)
            print(*cells, sep="\t", file=out)


def latest(lines: Iterable[Line], build: str) -> dict[str, Line]:
    """Return the newest line of each work for a build."""
    return {line.work: line for line in lines if line.build == build}


def compare(before: Mapping[str, Figures], now: Mapping[str, Outcome]) -> list[Finding]:
    """Return what differs by more than `GROWTH`: growth fails, and a work that no longer runs."""
    findings = []
    for work, outcome in now.items():
        if isinstance(outcome, str):
            findings.append(Finding(work, f"did not run: {outcome}", True))
        elif work not in before:
            findings.append(Finding(work, "has no line yet", False))
        else:
            findings += _differences(work, before[work], outcome)
    gone = before.keys() - now.keys()
    return findings + [Finding(work, "is no work any more", False) for work in sorted(gone)]


def _differences(work: str, before: Figures, now: Figures) -> Sequence[Finding]:
    findings = []
    for name, old, new in zip(Figures._fields, before, now, strict=True):
        slack = _HALF if name == "allocations" else 0.0
        if abs(new - old) <= GROWTH * old + slack:
            continue
        change = f"{(new - old) / old:+.1%}" if old else f"{new:+g}"
        text = f"{name} {change}: expected {old:,} within {GROWTH:.0%}, got {new:,}"
        findings.append(Finding(work, text, new > old))
    return findings
