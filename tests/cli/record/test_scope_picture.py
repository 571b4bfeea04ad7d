"""Pictures of recordings: curves, progress."""

import io

from rich.console import Console

from achse.cli.record.scope_picture import POINTS, ScopePicture, lines_of
from achse.client.scope import ScopeRows
from achse.scope import SCOPE_TYPES, ScopeBlock, ScopeChannel, ScopeData


def long_one(values: list[float]) -> ScopeData:
    type = SCOPE_TYPES["REAL64"]
    rows = b"".join(type.word(value).to_bytes(8, "little", signed=True) for value in values)
    block = ScopeBlock(0, 1_000_000, (ScopeChannel("a"),), (type,), (len(values),), rows)
    return ScopeData("long", (block,))


def test_peaks_of_long_recordings_are_seen() -> None:
    lines = lines_of(long_one([0.0] * 5000 + [70.0] + [0.0] * 5000))
    assert sum("⡇" in line or "⢸" in line or "⣇" in line for line in lines) >= 4, lines
    assert lines_of(long_one([])) == []


def test_the_live_picture_goes_on_with_the_rows() -> None:
    group = {
        "step_ns": 1_000_000,
        "begin_ns": 0,
        "channels": [{"name": "a", "symbol": "a", "type": "REAL64", "lost": "", "length": None}],
    }
    for live in (True, False):
        picture = ScopePicture([group], 2.0, live=live)
        rows = bytes(long_one([float(n % 50) for n in range(1000)]).blocks[0].rows)
        with picture:
            picture.add(ScopeRows(0, 1000, 0, rows, 0))
            picture.add(ScopeRows(0, 1000, 1000, rows, 0))
        out = io.StringIO()
        Console(file=out, width=80).print(picture.picture())
        assert "2.0 s, 2000 samples" in out.getvalue()
        assert "⣀" in out.getvalue() or "⡇" in out.getvalue() or "a" in out.getvalue()
    assert POINTS
