"""Blocking methods derived from coroutine methods: parameters, types, docstrings, threads."""

import inspect
import threading
from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self, assert_type, get_type_hints

import pytest

from achse.ams import AdsError
from achse.client import blocking as client
from achse.client.loop import LoopThread
from achse.client.nc import blocking as nc
from achse.client.nc.blocking_tables import RemoteTable
from achse.client.nc.status import AxisStatus
from achse.client.scope_blocking import BlockingScope
from achse.client.wrapper import ContextWrapper, Wrapper, blocking, wrapping
from tests.public_names import public_names


class Line:
    """An asyncio class with one method of each kind."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.ended_by: type[BaseException] | None = None
        self.is_open = False

    def __repr__(self) -> str:
        return f"Line({self.name})"

    async def __aenter__(self) -> Self:
        self.is_open = True
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.is_open, self.ended_by = False, kind

    async def text(self, count: int, /, separator: str = "", **options: object) -> str:
        """The name, repeated: `await line.text(2)`."""
        return f"{separator.join([self.name] * count)} {options} {threading.current_thread().name}"

    async def opened(self, name: str) -> "Line":
        return Line(name)

    def beside(self, name: str = "other") -> "Line":
        """`async with line.beside() as other: async for … in other`."""
        return Line(f"{name} {threading.current_thread() is threading.main_thread()}")


def _line(loop: LoopThread, inner: Line) -> "BlockingLine":
    return BlockingLine(loop, inner)


class BlockingLine(Wrapper[Line]):
    text = blocking(Line.text)
    opened = blocking(Line.opened, _line)
    beside = wrapping(Line.beside, _line)


class Opened(ContextWrapper[Line]):
    opened = blocking(Line.opened, BlockingLine)


@pytest.fixture
def loop() -> Iterator[LoopThread]:
    thread = LoopThread()
    yield thread
    thread.stop()


def test_derived_method_runs_in_the_loop_with_all_arguments(loop: LoopThread) -> None:
    line = BlockingLine(loop, Line("a"))
    assert line.text(2, "-", self=1, method=2) == "a-a {'self': 1, 'method': 2} achse client"
    assert line.text(1, separator="-") == "a {} achse client"
    with pytest.raises(TypeError, match=r"Line\.text\(\) missing 1 required positional"):
        line.text()  # type: ignore[call-arg]


def test_derived_method_has_the_signature_of_its_source() -> None:
    assert inspect.signature(BlockingLine.text) == inspect.signature(Line.text)
    parameters = inspect.signature(BlockingLine.beside).parameters
    assert parameters == inspect.signature(Line.beside).parameters
    assert get_type_hints(BlockingLine.text) == get_type_hints(Line.text)
    assert not inspect.iscoroutinefunction(BlockingLine.text)


def test_wrapped_result_is_the_annotated_one() -> None:
    for method in (BlockingLine.opened, BlockingLine.beside, Opened.opened):
        assert get_type_hints(method)["return"] is BlockingLine
    assert inspect.signature(Opened.opened).return_annotation is BlockingLine
    assert get_type_hints(Line.opened)["return"] is Line


def test_derived_method_is_named_after_its_class() -> None:
    assert BlockingLine.text.__qualname__ == "BlockingLine.text"
    assert BlockingLine.text.__module__ == __name__
    assert Opened.opened.__qualname__ == "Opened.opened"
    assert Line.text.__qualname__ == "Line.text"


def test_docstring_shows_blocking_code() -> None:
    assert BlockingLine.text.__doc__ == "The name, repeated: `line.text(2)`."
    assert BlockingLine.beside.__doc__ == "`with line.beside() as other: for … in other`."
    assert BlockingLine.opened.__doc__ is None


@pytest.mark.parametrize(
    "kind",
    [
        *(client.Target, client.Client, client.Subscription, BlockingScope, RemoteTable),
        *(getattr(nc, name) for name in public_names(nc)),
    ],
)
def test_no_docstring_of_the_blocking_client_shows_asyncio(kind: type) -> None:
    for name, member in inspect.getmembers(kind):
        if not name.startswith("_"):
            text = inspect.getdoc(member) or ""
            assert not {"await", "`await", "async", "`async"} & set(text.split()), name


def test_results_are_wrapped_and_sync_methods_stay_in_the_thread(loop: LoopThread) -> None:
    line = BlockingLine(loop, Line("a"))
    assert repr(line.opened("b")) == "Line(b)"
    assert repr(line.beside()) == "Line(other True)"


def test_context_is_entered_and_left_with_the_error(loop: LoopThread) -> None:
    line = Line("a")
    opened = Opened(loop, line)
    with opened as entered:
        assert entered is opened
        assert line.is_open
    assert (line.is_open, line.ended_by) == (False, None)
    with pytest.raises(KeyError), opened:
        raise KeyError
    assert (line.is_open, line.ended_by) == (False, KeyError)


def typed_use(plc: client.Client, x: nc.RemoteAxis, table: RemoteTable) -> None:
    """Checked by mypy, never called: what callers get, and what is refused."""
    assert_type(plc.read("MAIN.n"), Any)
    assert_type(plc.read_raw(1, 2, length=3), bytes)
    assert_type(plc.read_many(["MAIN.n"]), dict[str, Any])
    assert_type(plc.read_many(["MAIN.n"], strict=False), dict[str, Any | AdsError])
    assert_type(plc.within(1.0), client.Target)
    assert_type(plc.scope("MAIN.n", length=1.0), BlockingScope)
    with plc.subscribe("MAIN.n", mode="cycle") as samples:
        assert_type(samples, client.Subscription)
    assert_type(x.move_to(1.0, velocity=2.0, modulo="+"), nc.Move)
    assert_type(x.halt().finished(within=1.0), AxisStatus)
    assert_type(x.parameters["max velocity"], nc.AxisValue)
    assert_type(table.read_rows(), list[tuple[float, ...]])
    x.move_to(1.0)  # type: ignore[call-arg]
    x.move_to(1.0, velocity="fast")  # type: ignore[arg-type]
    plc.write("MAIN.n")  # type: ignore[call-arg]
    plc.read(name=5)  # type: ignore[arg-type]
