"""Machine code: records in memory, the cache, and what it is keyed by."""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from achse.native.compiled import Kernel, cache_directory, compiler_installed
from achse.native.declare import Slot, lay_out, plain_record, reference
from achse.native.memory import Rows, RowView
from achse.native.translate import TranslationError


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


class Cart:
    load: float = 2.0
    front: Any = reference(WHEEL)
    back: Any = reference(WHEEL)


CART = lay_out("cart", [Cart], Slot)

DRIVEN = """
from collections.abc import Sequence

def drive(carts: Sequence[Cart], way: float) -> float:
    for i in range(len(carts)):
        cart = carts[i]
        wheel = cart.front
        wheel.angle += way * cart.load
        cart.back.turns += 1
        cart.front.marks[1] += both(cart.front, cart.back)
    return carts[0].front.angle

def both(a: Wheel, b: Wheel) -> float:
    return a.angle + b.turns
"""


def test_a_record_refers_to_records(written: Any) -> None:
    module = written(DRIVEN, Wheel=Wheel, Cart=Cart)
    kernel = Kernel("carts", module.drive, {Wheel: WHEEL, Cart: CART})
    wheels, carts = Rows(WHEEL, 3), Rows(CART, 2)
    plain: list[Any] = [plain_record(CART)() for _ in range(2)]
    for cart, each in enumerate(plain):
        view = RowView(carts, cart)
        each.front, each.back = Plain(), Plain()
        view.reals[0] = 2.0
        view.refer(CART.fields["front"], RowView(wheels, cart))
        view.refer(CART.fields["back"], RowView(wheels, 2))
        assert view.content(CART) == bytes(view.row[:8]) + bytes(16)
    plain[0].back = plain[1].back
    plain[0].back.turns = plain[0].front.turns = plain[1].front.turns = 0
    for way in (0.5, 0.25):
        assert kernel.plain(plain, way) == kernel.function(carts.address, 2, way)
    for index, wheel in enumerate((plain[0].front, plain[1].front, plain[0].back)):
        assert wheels.row(index).cast("d")[0] == wheel.angle
        assert wheels.row(index).cast("q")[1] == wheel.turns
        assert wheels.row(index).cast("d")[2:].tolist() == wheel.marks


def test_a_reference_is_not_set(written: Any) -> None:
    module = written("def turn(c: Cart) -> None:\n    c.front = c.back\n", Cart=Cart)
    with pytest.raises(TranslationError, match="only numbers can be stored"):
        _ = Kernel("carts", module.turn, {Cart: CART}).function
