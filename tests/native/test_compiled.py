"""Machine code: records in memory, the cache, and what it is keyed by."""

import importlib
import math
import os
import re
import sys
import zipfile
from array import array
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from achse.native.backend import address_of
from achse.native.compiled import Kernel, checked_builds
from achse.native.declare import Slot, lay_out, pack, plain_record, reference, within
from achse.native.kernels.arithmetic import TranslationError
from achse.native.memory import Rows, RowView


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


SUM = """
def weighed(count: int, weight: float, more: int, less: float) -> float:
    return count * weight + more - less
"""


@pytest.mark.parametrize("first", range(5))
@pytest.mark.parametrize("checked", [False, True])
def test_kernel_takes_any_number_of_its_arguments_beforehand(
    written: Any, first: int, checked: bool
) -> None:
    kernel = Kernel("weighed", written(SUM).weighed, {})
    arguments = 3, 2.5, -7, 0.125
    with checked_builds() if checked else nullcontext():
        bound = kernel.bind(*arguments[:first])
        assert bound(*arguments[first:]) == kernel.plain(*arguments) == 0.375
        other = 5, 1.5, 2, 4.0
        if first < 4:
            assert bound(*other[first:]) == kernel.plain(*arguments[:first], *other[first:])
        assert bound(*arguments[first:]) == 0.375


def test_the_cache_is_used_again(
    written: Any, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = written(SOURCE, Wheel=Wheel, STEP=9.0)
    first, second = (Kernel("wheels", module.turn, {Wheel: WHEEL}) for _ in range(2))
    assert not first.cached
    assert first.function(Rows(WHEEL, 1).address, 1, 0.0) == 1
    assert second.cached
    monkeypatch.setattr("achse.native.kernels.translate.translate", None)
    assert second.path.parent == cache
    assert second.function(Rows(WHEEL, 2).address, 2, 0.0) == 2


def test_a_broken_file_in_the_cache_is_made_again(written: Any) -> None:
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
        view.floats[0] = 2.0
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


def test_a_reference_that_leads_nowhere_is_trapped(written: Any) -> None:
    module = written("def turn(c: Cart) -> float:\n    return c.front.angle\n", Cart=Cart)
    kernel = Kernel("carts", module.turn, {Cart: CART})
    with checked_builds(), pytest.raises(AttributeError, match="front leads nowhere"):
        kernel.function(Rows(CART, 1).address)


RAISING = {
    "marks[n]": (IndexError, "index"),
    "wheels[n].angle": (IndexError, "index"),
    "wheels[0].marks[n]": (IndexError, "index"),
    "TABLE[n]": (IndexError, "index"),
    "7 % n": (ZeroDivisionError, "zero"),
    "7 // n": (ZeroDivisionError, "zero"),
    "1.5 / n": (ZeroDivisionError, "zero"),
    "7 / n": (ZeroDivisionError, "zero"),
    "x % float(n)": (ZeroDivisionError, "zero"),
    "int(x)": (OverflowError, "integer"),
    "round(x)": (OverflowError, "integer"),
    "math.floor(x)": (OverflowError, "integer"),
    "int(x - x)": (ValueError, "NaN"),
    "math.sqrt(n)": (ValueError, "domain"),
    "math.log(float(n))": (ValueError, "domain"),
    "math.asin(float(n))": (ValueError, "domain"),
    "math.exp(n * 300.0)": (OverflowError, "range"),
    "math.sin(x)": (ValueError, "domain"),
    "abs(float(n)) ** -1.5": (ZeroDivisionError, "zero"),
    "9.0 ** (x * 1e200)": (OverflowError, "range"),
    "1 << n": (ValueError, "shift"),
    "7 >> n": (ValueError, "shift"),
}
"""What can raise with some n in -9..9, or with x beyond all numbers."""

BEYOND = ("n * BIG", "n + BIG", "n - BIG", "-(n - BIG)", "abs(n - BIG)", "1 << abs(n % 100)")


def outcome(run: Callable[..., Any], *arguments: Any, texts: list[str] | None = None) -> Any:
    """What comes out, or the class of what is raised."""
    try:
        return run(*arguments)
    except (ArithmeticError, LookupError, ValueError) as error:
        if texts is not None:
            texts.append(str(error))
        return type(error)


@pytest.mark.parametrize(("expression", "raised"), RAISING.items())
def test_checked_code_raises_where_python_does(
    written: Any, expression: str, raised: tuple[type[Exception], str]
) -> None:
    module = written(
        "import math\nfrom collections.abc import Sequence\nTABLE = (1.5, 2.5, 3.5)\n"
        "def run(wheels: Sequence[Wheel], marks: Sequence[float], n: int, x: float) -> float:\n"
        "    return inner(wheels, marks, n, x) + 0.0\n"
        "def inner(wheels: Sequence[Wheel], marks: Sequence[float], n: int, x: float) -> float:\n"
        f"    return float({expression})\n",
        Wheel=Wheel,
    )
    kernel = Kernel("raising", module.run, {Wheel: WHEEL})
    plain: list[Any] = [Plain() for _ in range(4)]
    rows, marks = Rows(WHEEL, 4), array("d", bytes(16))
    seen: set[Any] = set()
    texts: list[str] = []
    with checked_builds():
        bound = kernel.bind(rows.address, 4, *marks.buffer_info())
    for n in range(-9, 10):
        for x in (2.5, math.inf):
            expected = outcome(kernel.plain, plain, marks, n, x)
            came = outcome(bound, n, x, texts=texts)
            assert came == expected or (math.isnan(came) and math.isnan(expected))
            seen.add(expected)
    assert raised[0] in seen
    assert all(re.match(r"/.*written_\d+\.py:7: inner: ", text) for text in texts)
    assert any(raised[1] in text for text in texts)


@pytest.mark.parametrize("expression", BEYOND)
def test_checked_code_refuses_what_needs_more_than_64_bits(written: Any, expression: str) -> None:
    module = written(f"BIG = {2**62}\ndef run(n: int) -> int:\n    return {expression}\n")
    kernel = Kernel("beyond", module.run, {})
    with checked_builds():
        run = kernel.function
    raised = 0
    for n in (0, 1, -1, 2, -2, 7, -7, 70, 2**62, -(2**63)):
        expected = kernel.plain(n)
        if -(2**63) <= expected < 2**63:
            assert run(n) == expected
        else:
            raised += 1
            with pytest.raises(OverflowError, match="beyond 64 bits"):
                run(n)
    assert raised


def test_checked_code_refuses_what_is_not_a_byte(written: Any) -> None:
    module = written("def run(b: bytearray, n: int) -> None:\n    b[n] = n - 1\n")
    kernel, buffer = Kernel("bytes", module.run, {}), bytearray(300)
    with checked_builds():
        run = kernel.bind(address_of(buffer), len(buffer))
    run(256)
    assert buffer[256] == 255
    for n in (0, 257):
        with pytest.raises(ValueError, match=f"{n - 1} is not a byte"):
            run(n)
    with pytest.raises(IndexError, match="index 300 of 300 elements"):
        run(300)


def test_both_builds_live_side_by_side(written: Any) -> None:
    kernel = _kernel(written, step=3.0)
    plain = kernel.path
    with checked_builds():
        assert kernel.path != plain
        assert kernel.function is not None
        assert kernel.cached
    assert not kernel.cached
    rows = Rows(WHEEL, 2)
    assert kernel.function(rows.address, 2, 0.5) == 2


TABLES = """
from collections.abc import Sequence

class Garage:
    carts: Sequence[Wheel]
    wheels: Sequence[Wheel]
    marks: Sequence[int]

def run(garage: Garage, by: float) -> int:
    for n in range(len(garage.wheels)):
        one(garage, n, by)
    return garage.marks[0]

def one(garage: Garage, n: int, by: float) -> None:
    wheel = garage.wheels[n]
    wheel.angle += by * garage.carts[wheel.turns].angle
    garage.marks[0] = garage.marks[0] + n
"""


def test_an_entry_works_on_tables_of_several_records(written: Any) -> None:
    module = written(TABLES, Wheel=Wheel)
    kernel = Kernel("garage", module.run, {Wheel: WHEEL})
    garage = module.Garage()
    garage.carts, garage.wheels, garage.marks = [Plain()], [Plain(), Plain()], [5]
    garage.carts[0].angle = 0.25
    carts, wheels, marks = Rows(WHEEL, 1), Rows(WHEEL, 2), array("q", [5])
    carts.row(0).cast("d")[0] = 0.25
    run = kernel.bind(carts.address, 1, wheels.address, 2, *marks.buffer_info())
    assert run(2.0) == kernel.plain(garage, 2.0) == 6
    assert wheels.row(1).cast("d")[0] == garage.wheels[1].angle == 0.5
    wrong = written(TABLES.replace("garage.marks[0]\n", "garage.brakes[0]\n"), Wheel=Wheel)
    with pytest.raises(TranslationError, match="Garage has no rows brakes"):
        _ = Kernel("garage", wrong.run, {Wheel: WHEEL}).function


def test_without_sources_there_is_no_machine_code(
    written: Any, caplog: pytest.LogCaptureFixture
) -> None:
    """As in a program frozen into one file: the plain kernel runs, and the log says so."""
    module = written(SOURCE, Wheel=Wheel, STEP=1.0)
    Path(module.__file__).unlink()
    module.__loader__ = None
    kernel = Kernel("frozen", module.turn, {Wheel: WHEEL})
    assert not kernel.available
    assert "the frozen kernel runs as plain Python: " in caplog.text
    assert "its source is not there" in caplog.text


def test_sources_may_be_in_a_zip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "app.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("zipped_kernel.py", "def run(n: int) -> int:\n    return 3 * n\n")
    monkeypatch.syspath_prepend(str(path))
    kernel = Kernel("zipped", importlib.import_module("zipped_kernel").run, {})
    assert kernel.available
    assert kernel.function(7) == 21


def test_without_compiler_there_is_no_machine_code(
    written: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    assert not _kernel(written, step=4.0).available


class Train:
    length: int = 3
    engine: Any = within(WHEEL)
    axles: Any = within(WHEEL, length=3)


TRAIN = lay_out("train", [Train], Slot)

ROLLED = """
from collections.abc import Sequence

def roll(trains: Sequence[Train], way: float, n: int) -> float:
    train = trains[1]
    turn(train.engine, way)
    total = 0.0
    for i in range(train.length):
        turn(train.axles[i], way * i)
        total += train.axles[i].angle
    last = train.engine
    if n > 0:
        last = train.axles[n]
    last.marks[2] += total
    train.axles[-1].turns += len(train.axles)
    return total

def turn(wheel: Wheel, way: float) -> None:
    wheel.angle += way
    wheel.turns += 1
"""


def test_a_record_holds_records(written: Any) -> None:
    module = written(ROLLED, Wheel=Wheel, Train=Train)
    kernel = Kernel("trains", module.roll, {Wheel: WHEEL, Train: TRAIN})
    trains = Rows(TRAIN, 2)
    plain: list[Any] = [plain_record(TRAIN)() for _ in range(2)]
    trains.row(1)[:] = pack(TRAIN, plain[1])
    with checked_builds():
        checked = kernel.function
    for n in (0, 2, 1, 0):
        assert kernel.plain(plain, 0.5, n) == kernel.function(trains.address, 2, 0.5, n)
        assert bytes(trains.row(1)) == pack(TRAIN, plain[1])
    with pytest.raises(IndexError, match="index 3 of 3 elements"):
        checked(trains.address, 2, 0.5, 3)
    assert not any(trains.row(0))
