"""Pictures of the documentation, made from the code they show: none is kept in the repository."""

import io
import itertools
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from achse.site.moving import demo_picture, still_demo_picture

_LEDGER = Path(__file__).parents[3] / "benchmarks" / "ledger" / "figures.tsv"
_STEP = 0.002
_PROGRAM = """PROGRAM MAIN
VAR
    nCount : INT;
    sText : STRING(20);
END_VAR
nCount := sText + 1;
nCout := 2;
END_PROGRAM
"""


def _profile() -> str:
    """Position, velocity and acceleration of a jerk-limited move, by matplotlib."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    names = ("position, mm", "velocity, mm/s", "acceleration, mm/s²")
    moments, curves = _samples()
    with matplotlib.rc_context({"svg.hashsalt": "achse", "svg.fonttype": "none"}):
        figure, panels = pyplot.subplots(3, 1, sharex=True, figsize=(7, 5), layout="constrained")
        for panel, name, curve in zip(panels, names, curves, strict=True):
            panel.plot(moments, curve)
            panel.set_ylabel(name)
            panel.grid(alpha=0.3)
        panels[-1].set_xlabel("time, s")
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
        pyplot.close(figure)
    return out.getvalue()


def _samples() -> tuple[list[float], list[list[float]]]:
    """Return the move of CONTRIBUTING: 0 to 100 mm at 50 mm/s, 500 and 400 mm/s², 5000 mm/s³."""
    from achse.motion.profiles.profile import plan_to_position
    from achse.motion.profiles.segments import (
        MAX_SEGMENTS,
        segment_acceleration,
        segment_position,
        segment_velocity,
    )

    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    count = plan_to_position(times, jerks, 0.0, 0.0, 0.0, 100.0, 0.0, 50.0, 500.0, 400.0, 5000.0)
    moments: list[float] = []
    curves: list[list[float]] = [[], [], []]
    begin, p, v, a = 0.0, 0.0, 0.0, 0.0
    for span, jerk in itertools.islice(zip(times, jerks, strict=True), count):
        steps = max(int(span / _STEP), 1)
        for k in range(steps + 1):
            t = span * k / steps
            moments.append(begin + t)
            curves[0].append(segment_position(t, jerk, p, v, a))
            curves[1].append(segment_velocity(t, jerk, v, a))
            curves[2].append(segment_acceleration(t, jerk, a))
        begin, (p, v, a) = begin + span, (curve[-1] for curve in curves)
    return moments, curves


def _terminal() -> str:
    """`achse check` and what it finds, as a terminal shows it."""
    from rich.console import Console
    from rich.text import Text

    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "main.st").write_text(_PROGRAM, encoding="utf-8")
        settings: Mapping[str, Any] = {"cwd": folder, "text": True, "encoding": "utf-8"}
        output = subprocess.run(
            [sys.executable, "-m", "achse", "check", "main.st"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            env={**os.environ, "FORCE_COLOR": "1", "COLUMNS": "80"},
            **settings,
        ).stdout
    console = Console(record=True, width=84, file=io.StringIO(), force_terminal=True)
    console.print("$ achse check main.st")
    console.print(Text.from_ansi(output))
    drawn = console.export_svg(title="achse", unique_id="achse")
    return re.sub(r"@font-face \{.*?\}", "", drawn, flags=re.DOTALL)  # they are on a foreign host


def _ledger() -> str:
    """Instructions of the ledger's works over its commits, as a ratio to their first line."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    histories = _histories()
    commits = list(dict.fromkeys(commit for each in histories.values() for commit, _ in each))
    with matplotlib.rc_context({"svg.hashsalt": "achse", "svg.fonttype": "none"}):
        height = 1.2 + 0.25 * len(histories)
        figure, panel = pyplot.subplots(figsize=(8, height), layout="constrained")
        for row, history in enumerate(histories.values()):
            ratios = [count / history[0][1] for _, count in history]
            panel.plot(ratios, [row] * len(ratios), color="0.7", linewidth=1.0, zorder=1)
        for number, commit in enumerate(commits):
            points = [
                (count / history[0][1], row)
                for row, history in enumerate(histories.values())
                for each, count in history
                if each == commit
            ]
            shade = pyplot.get_cmap("viridis_r")((number + 1) / len(commits))
            ratios, rows = ([point[axis] for point in points] for axis in (0, 1))
            panel.scatter(ratios, rows, s=25, color=shade, label=commit, zorder=2)
        panel.set_yticks(
            range(len(histories)), [f"{name}  {h[-1][1]:,}" for name, h in histories.items()]
        )
        panel.invert_yaxis()
        panel.set_xscale("log")
        ticks = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)
        panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
        panel.set_xlabel("instructions, first line = 1; the newest figure is beside the name")
        panel.grid(alpha=0.3)
        panel.legend(title="commit", loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=6)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
        pyplot.close(figure)
    return out.getvalue()


def _histories() -> dict[str, list[tuple[str, int]]]:
    """Commit and instructions of each work, oldest first, of the build with the newest line."""
    text = _LEDGER.read_text(encoding="utf-8").splitlines()
    rows = [dict(zip(text[0].split("\t"), line.split("\t"), strict=True)) for line in text[1:]]
    histories: dict[str, list[tuple[str, int]]] = {}
    for row in rows:
        if row["build"] == rows[-1]["build"]:
            entry = row["commit"], int(row["instructions"])
            histories.setdefault(row["work"], []).append(entry)
    return histories


PICTURES: Mapping[str, Callable[[], str]] = {
    "demo": demo_picture,
    "demo_still": still_demo_picture,
    "profile": _profile,
    "terminal": _terminal,
    "ledger": _ledger,
}
"""Functions that make the SVG, by name."""

TEXTS: Mapping[str, str] = {
    "demo": "A terminal plays achse demo: an axis is enabled and moves from 0 to 100 mm, the scope"
    " records the next move, and reads of a variable are refused on demand",
    "profile": "Position, velocity and acceleration of a jerk-limited move over time",
    "terminal": "A terminal shows what achse check finds in a program with two errors",
    "ledger": "Instructions of each fixed work over the commits, relative to its first line",
}
"""Alternative texts by name of the picture."""

MOVING = frozenset({"demo"})
"""Pictures with a still one beside them, for readers who want less motion."""
