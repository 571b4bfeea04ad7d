"""The text form of the vendor's scope export: tabs, decimal point, metadata above the columns.

Structure and keys as `pytcs` reads them and its test files have them (scope 3.4). Channels of one
sample time and length share a time column, which repeats the key word in each metadata line.

A text that a spreadsheet would run as a formula gets an apostrophe (CSV injection, OWASP).
"""

import io
import re
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import Any, TextIO

from achse.scope.data import ScopeData, ScopeTrack

_FILETIME_EPOCH = 116_444_736_000_000_000
"""1970-01-01 in units of 100 ns since 1601-01-01."""

_CELLS = 2048
"""Cells that are put together at once: little, so that others come to their turn."""

_KEYS: tuple[tuple[str, Callable[[ScopeTrack], str]], ...] = (
    ("Name", lambda track: track.channel.name),
    ("SymbolComment", lambda track: track.channel.comment),
    ("Data-Type", lambda track: track.type.name),
    ("SampleTime[ms]", lambda track: f"{track.step_ns / 1e6:g}"),
    ("VariableSize", lambda track: str(track.type.size)),
    ("SymbolBased", lambda track: str(bool(track.channel.symbol))),
    ("IndexGroup", lambda track: str(track.channel.index_group)),
    ("IndexOffset", lambda track: str(track.channel.index_offset)),
    ("SymbolName", lambda track: track.channel.symbol),
    ("NetID", lambda track: "Local"),
    ("Port", lambda track: str(track.channel.port)),
    ("Offset", lambda track: f"{track.channel.offset:g}"),
    ("ScaleFactor", lambda track: f"{track.channel.scale:g}"),
    ("BitMask", lambda track: "0xffffffffffffffff"),
    ("Unit", lambda track: track.channel.unit or "(None)"),
    ("Unit ScaleFactor", lambda track: "1"),
    ("Unit Offset", lambda track: "0"),
)
"""The lines above the columns, in the order of the original."""


def csv_text(data: ScopeData, file: str = "") -> str:
    """Return the whole text; `file` is the name that it has in the second line."""
    text = io.StringIO()
    _write(data, file, text)
    return text.getvalue()


def write_csv(data: ScopeData, path: Path) -> None:
    """Write the file, UTF-8, lines end with CR LF. Raises OSError."""
    with path.open("w", encoding="utf-8", newline="\r\n") as stream:
        _write(data, str(path.name), stream)


def _write(data: ScopeData, file: str, stream: TextIO) -> None:
    # a channel without a sample would leave blanks in the first row, where readers look for signs
    tracks = [track for track in data.tracks if len(track)]
    # one that ends early has a time column of its own: readers want both equally long
    groups: dict[tuple[int, int], list[ScopeTrack]] = {}
    for track in tracks:
        groups.setdefault((id(track.block), len(track)), []).append(track)
    stream.write(f"Name\t{_cell(data.name)}\nFile\t{_cell(file)}\n")
    for key, unix_ns in (("Starttime", data.begin_ns), ("Endtime", data.end_ns)):
        stream.write(f"{key} of export\t{_moment(unix_ns)}\n")
    stream.write("\n\n")
    for key, fact in _KEYS:
        cells: list[str] = []
        for group in groups.values():
            cells += (key, *(_cell(fact(track)) for track in group))
        stream.write("\t".join(cells) + "\n")
    stream.write("\n")
    for part in _lines(list(groups.values())):
        stream.write(part)
    stream.write("EOF\n")


def _lines(groups: list[list[ScopeTrack]]) -> Iterator[str]:
    """Yield the samples, some lines at a time; a column that ends early has blanks."""
    most = max((len(group[0]) for group in groups), default=0)
    rows = max(_CELLS // (sum(map(len, groups)) + len(groups)), 1) if groups else 1
    for first in range(0, most, rows):
        last = min(first + rows, most)
        columns = []
        for group in groups:
            columns.append(list(map(repr, group[0].part_times_ms(first, last))))
            columns += (_texts(track, first, last) for track in group)
        size = last - first
        filled = (column + [" "] * (size - len(column)) for column in columns)
        lines = zip(*filled, strict=True)
        yield "".join(chain.from_iterable(("\t".join(line), "\n") for line in lines))


_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?", re.IGNORECASE)

_FORMULA = re.compile(r"""((?:^|[,;|"]) ?)(?=[=+@\uFF1D\uFF0B\uFF0D\uFF20-])""")
"""Begin of a formula in a cell, also where a spreadsheet splits at `,`, `;` or `|` or drops quotes.

The last four signs are the wide forms, which some spreadsheets take for the plain ones.
"""


def _cell(text: str) -> str:
    """Return a text without separators of cells and lines, and without formulas; numbers stay."""
    line = " ".join(text.split())
    return line if _NUMBER.fullmatch(line) else _FORMULA.sub(r"\1'", line)


def _moment(unix_ns: int) -> str:
    moment = datetime.fromtimestamp(unix_ns / 1e9, UTC)
    filetime = unix_ns // 100 + _FILETIME_EPOCH
    return f"{filetime}\t{moment:%Y-%m-%d\t%H:%M:%S}.{moment.microsecond // 1000:03}"


def _texts(track: ScopeTrack, first: int, last: int) -> list[str]:
    """Values as readers take them: no plus sign, BOOL as 0 and 1."""
    values: Iterable[Any] = track.part(first, last)
    if track.type.real or track.channel.scaled:
        return [repr(float(value)).replace("e+", "e") for value in values]
    if track.type.code == "?":
        return ["1" if value else "0" for value in values]
    return list(map(str, values))
