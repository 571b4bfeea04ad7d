"""Moving picture of the front page: `achse demo` as a terminal, and the axis that it moves.

`record` plays the demo and keeps each line with its moment, as an asciicast (asciinema's format,
version 2). `moving_picture` draws a cast as SVG that CSS animates once; `still_picture` is its end,
for readers who asked their system for less motion. With ACHSE_DEMO_CAST the cast is read from that
file and nothing is played.
"""

import asyncio
import json
import os
import re
import subprocess
import sys
import time
from functools import cache
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import escape

CAST_FILE = "ACHSE_DEMO_CAST"
"""Environment variable with the name of a cast to draw instead of a new one."""

LONGEST_PAUSE_S = 0.5
"""A pause between two lines is shown no longer than this."""

ROWS = 22
COLUMNS = 92
_LEFT, _LINE_HEIGHT, _FONT = 16, 17, 13.0
_TRACK_TOP, _TRACK_LEFT, _TRACK_RIGHT = 34, 120, 600
_TERMINAL_TOP = 74
_SAMPLE_S = 0.02
_PAGE = re.compile(r" \(http://[^)]*\)$")
"""Address of a page of the demo's station, which has ended."""
_MOVE = "$ achse axis move X --to 100"
_STYLE = """
text{font:13px ui-monospace,Consolas,monospace;fill:#e6e6e6;white-space:pre}
.command{fill:#7ee787}.heading{fill:#79c0ff}
"""


class TerminalLine(NamedTuple):
    """A line of the terminal and its moment, s after the first."""

    moment: float
    text: str


def record() -> str:
    """Return a cast of `achse demo`. Raises CalledProcessError if the demo fails."""
    words = [sys.executable, "-m", "achse", "demo", "--yes"]
    environment = {**os.environ, "COLUMNS": str(COLUMNS), "NO_COLOR": "1"}
    events = [json.dumps({"version": 2, "width": COLUMNS, "height": ROWS})]
    with subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        env=environment,
    ) as process:
        assert process.stdout is not None
        begin = time.monotonic()
        for line in process.stdout:
            event = [round(time.monotonic() - begin, 3), "o", line.rstrip("\n") + "\r\n"]
            events.append(json.dumps(event, ensure_ascii=False))
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, words)
    return "\n".join(events) + "\n"


def lines_of(cast: str) -> list[TerminalLine]:
    """Return the lines of a cast, with pauses cut to LONGEST_PAUSE_S. Raises ValueError."""
    header, *events = [json.loads(line) for line in cast.splitlines() if line]
    if not isinstance(header, dict) or header.get("version") != 2:
        raise ValueError(f"cast: expected a header of version 2, got {header!r}")
    lines: list[TerminalLine] = []
    last, shown = 0.0, 0.0
    for moment, kind, text in events:
        if kind == "o":
            shown += min(max(moment - last, 0.0), LONGEST_PAUSE_S)
            last = moment
            lines += [TerminalLine(shown, each) for each in text.removesuffix("\r\n").split("\r\n")]
    return lines


def axis_positions() -> list[float]:
    """Return positions of the demo's first move every 20 ms, mm: the same move in virtual time."""
    from achse.client import connect
    from achse.station import Station

    async def move() -> list[float]:
        station = Station.demo()
        async with connect(station.router, advance=station.advance) as client:
            x = client.nc.axis("X")
            await x.enable()
            await x.move_to(100, velocity=200, wait=False)
            positions = [0.0]
            while positions[-1] < 99.99:
                station.advance(_SAMPLE_S)
                positions.append((await x.status()).set_position)
            return positions

    return asyncio.run(move())


def moving_picture(lines: list[TerminalLine], positions: list[float]) -> str:
    """Return the SVG: lines appear at their moments, the carriage moves as its command says."""
    end = lines[-1].moment + 1.0
    begin = next((line.moment for line in lines if line.text.startswith(_MOVE)), 0.0)
    duration = len(positions) * _SAMPLE_S
    style = ".line{opacity:0;animation:appear 1ms forwards}@keyframes appear{to{opacity:1}}\n"
    style += f".lines{{animation:scroll {end:.3f}s step-end 1 forwards}}{_scrolling(lines, end)}"
    style += f".carriage{{animation:move {duration:.3f}s linear {begin:.3f}s forwards}}"
    return _drawn(lines, style + _moving(positions))


def still_picture(lines: list[TerminalLine], positions: list[float]) -> str:
    """Return the SVG of the end: the last lines, the carriage where it came to rest."""
    shift = f".carriage{{transform:translateX({_travelled(positions[-1]):.2f}px)}}"
    return _drawn(lines[-ROWS:], shift)


def _drawn(lines: list[TerminalLine], style: str) -> str:
    width = _LEFT * 2 + int(COLUMNS * _FONT * 0.602)
    height = _TERMINAL_TOP + ROWS * _LINE_HEIGHT + 8
    rows = "\n".join(_row(number, line) for number, line in enumerate(lines))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">\n'
        f"<style>{_STYLE}{style}</style>\n"
        f'<rect width="{width}" height="{height}" rx="8" fill="#10141a"/>\n{_track()}\n'
        f'<svg x="0" y="{_TERMINAL_TOP}" width="{width}" height="{ROWS * _LINE_HEIGHT}">'
        f'<g class="lines">\n{rows}\n</g></svg>\n</svg>\n'
    )


def _row(number: int, line: TerminalLine) -> str:
    text = _PAGE.sub("", line.text)
    text = text if len(text) <= COLUMNS else text[: COLUMNS - 1] + "…"
    kind = " command" if text.startswith("$ ") else " heading" if text[1:3] == ". " else ""
    return (
        f'<text class="line{kind}" x="{_LEFT}" y="{number * _LINE_HEIGHT + 13}"'
        f' style="animation-delay:{line.moment:.3f}s">{escape(text)}</text>'
    )


def _scrolling(lines: list[TerminalLine], end: float) -> str:
    """Keyframes that keep the newest line in sight."""
    steps = [
        f"{100 * line.moment / end:.3f}%{{transform:translateY({-_LINE_HEIGHT * over}px)}}"
        for number, line in enumerate(lines)
        if (over := number + 1 - ROWS) > 0
    ]
    last = f"100%{{transform:translateY({-_LINE_HEIGHT * max(len(lines) - ROWS, 0)}px)}}"
    return f"@keyframes scroll{{{''.join(steps)}{last}}}\n"


def _moving(positions: list[float]) -> str:
    """Keyframes of the carriage: the samples, with straight lines between them."""
    last = len(positions) - 1
    steps = (
        f"{100 * number / last:.2f}%{{transform:translateX({_travelled(position):.2f}px)}}"
        for number, position in enumerate(positions)
    )
    return f"@keyframes move{{{''.join(steps)}}}\n"


def _travelled(position: float) -> float:
    return position / 100 * (_TRACK_RIGHT - _TRACK_LEFT)


def _track() -> str:
    """Draw the axis: a rail with its ends and a carriage."""
    top, left, right = _TRACK_TOP, _TRACK_LEFT, _TRACK_RIGHT
    ends = f"M{left - 18} {top - 9}v18M{right + 18} {top - 9}v18"
    return (
        f'<text x="{_LEFT}" y="{top + 5}">axis X</text>'
        f'<text x="{left - 36}" y="{top + 5}">0</text>'
        f'<text x="{right + 28}" y="{top + 5}">100 mm</text>'
        f'<path d="M{left - 18} {top}H{right + 18}{ends}" stroke="#8b949e" stroke-width="2"/>'
        f'<rect class="carriage" x="{left - 14}" y="{top - 12}" width="28" height="24" rx="3"'
        ' fill="#f0883e"/>'
    )


@cache
def _played() -> str:
    """Return the cast of a demo, which is played once in a process."""
    return record()


def _lines() -> list[TerminalLine]:
    file = os.environ.get(CAST_FILE)
    return lines_of(Path(file).read_text(encoding="utf-8") if file else _played())


def demo_picture() -> str:
    """Return the moving picture of the front page as SVG."""
    return moving_picture(_lines(), axis_positions())


def still_demo_picture() -> str:
    """Return the end of the moving picture as SVG."""
    return still_picture(_lines(), axis_positions())
