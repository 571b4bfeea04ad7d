"""Machine code: records in memory, the cache, and what it is keyed by."""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from achse.native.compiled import Kernel, cache_directory, compiler_installed
from achse.native.declare import Slot, lay_out, plain_record
from achse.native.memory import Rows


class Wheel:
    angle: float = 0.0
    turns: int = 0
    marks: list[float] = [0.0] * 3


WHEEL = lay_out("wheel", [Wheel], Slot)
Plain = plain_record(WHEEL)

SOURCE = """
from collections.abc import Sequence

def turn(wheels: Sequence[Wheel], by: float) -> int:
    for i in range(len(wheels)):
        one(wheels[i], by, wheels[i - 1].marks)
    wheels[0].angle += wheels[-1].turns
    return len(wheels)

def one(w: Wheel, by: float, marks: Sequence[float]) -> None:
    w.angle += by * STEP
    while w.angle >= 1.0:
        w.angle -= 1.0
        w.turns += 1
        w.marks[w.turns % 3] = w.angle
        w.marks[-1] += marks[w.turns - 3]
"""


def _kernel(written: Callable[..., ModuleType], text: str = SOURCE, step: float = 1.0) -> Kernel:
    return Kernel("wheels", written(text, Wheel=Wheel, STEP=step).turn, {Wheel: WHEEL})


def test_records_are_worked_on_in_place(written: Any) -> None:
    kernel = _kernel(written)
    plain: Sequence[Any] = [Plain(), Plain(), Plain()]
    rows = Rows(WHEEL, 3)
    bound = kernel.bind(rows.address, rows.count)
    for by in (0.75, 0.5):
        assert kernel.plain(plain, by) == kernel.function(rows.address, rows.count, by) == 3
    assert kernel.plain(plain, 3.25) == bound(3.25) == 3
    for index, wheel in enumerate(plain):
        memory = rows.row(index)
        assert memory.cast("d")[0] == wheel.angle
        assert memory.cast("q")[1] == wheel.turns
        assert memory.cast("d")[2:].tolist() == wheel.marks


def test_the_cache_is_used_again(
    written: Any, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = written(SOURCE, Wheel=Wheel, STEP=9.0)
    first, second = (Kernel("wheels", module.turn, {Wheel: WHEEL}) for _ in range(2))
    assert not first.cached
    assert first.function(Rows(WHEEL, 1).address, 1, 0.0) == 1
    assert second.cached
    monkeypatch.setattr("achse.native.translate.translate", None)
    assert second.path.parent == cache
    assert second.function(Rows(WHEEL, 2).address, 2, 0.0) == 2


def test_a_broken_file_in_the_cache_is_made_anew(written: Any) -> None:
    module = written(SOURCE, Wheel=Wheel, STEP=7.0)
    first, second = (Kernel("wheels", module.turn, {Wheel: WHEEL}) for _ in range(2))
    assert first.function(Rows(WHEEL, 1).address, 1, 0.0) == 1
    whole = first.path.read_bytes()
    first.path.write_bytes(whole[: len(whole) // 2])
    assert second.function(Rows(WHEEL, 1).address, 1, 0.0) == 1
    assert first.path.read_bytes() == whole


def test_what_changes_the_code_changes_the_file(written: Any) -> None:
    paths = {
        _kernel(written).path,
        _kernel(written, step=2.0).path,
        _kernel(written, SOURCE + "\n").path,
        Kernel("wheels", written(SOURCE, Wheel=Wheel, STEP=1.0).turn, {}).path,
        Kernel("wheels", written(SOURCE, Wheel=Wheel, STEP=1.0).one, {Wheel: WHEEL}).path,
    }
    assert len(paths) == 5
    assert _kernel(written).path in paths


def test_a_cache_that_cannot_be_written_does_not_matter(
    written: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", os.path.join(os.devnull, "none"))
    kernel = _kernel(written)
    assert kernel.function(Rows(WHEEL, 1).address, 1, 0.0) == 1
    assert not kernel.cached


def test_the_cache_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", "/cache")
    assert cache_directory() == Path("/cache")
    monkeypatch.delenv("ACHSE_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache_directory() == Path("/xdg/achse")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == Path.home() / ".cache" / "achse"


def test_a_missing_compiler_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiler_installed()
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    assert not compiler_installed()
