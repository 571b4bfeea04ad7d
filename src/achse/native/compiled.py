"""A kernel: plain functions on records, as they are or as machine code; the latter needs llvmlite.

Machine code belongs to the kernel's sources, the numbers they refer to, the layout of the records,
the processor and the version of LLVM: a hash of these names its file in the cache.
"""

import ctypes
import hashlib
import logging
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import EnumMeta
from functools import cached_property, partial
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from achse.native.backend.cache import ObjectCache
from achse.native.backend.faults import MachineFault
from achse.native.backend.machine import (
    Effort,
    MachineCode,
    compile_module,
    compiler_installed,
    identity,
)
from achse.native.declare import RecordLayout
from achse.native.members import fold_members, reached
from achse.native.merging import merge_steps

_LOG = logging.getLogger(__name__)

_checked = False

merges = True
"""Plain kernels have the statements of their steps instead of calls (`merging`); not where tools
change single functions of a kernel."""


@contextmanager
def checked_builds() -> Iterator[None]:
    """Machine code that is bound within is checked: for tests.

    It raises what Python raises: IndexError, ZeroDivisionError, OverflowError or ValueError, with
    file and line of the kernel; and OverflowError where a whole number needs more than 64 bits.
    """
    global _checked
    before, _checked = _checked, True
    try:
        yield
    finally:
        _checked = before


class BoundCall(NamedTuple):
    """Machine code with its arguments, for other machine code that calls it."""

    function: int
    """Its address."""
    words: "array[int]"
    """Block of the arguments, one word each; the last ones may be set."""


def bound_call(bound: Callable[..., Any]) -> BoundCall | None:
    """Return the call behind a function of `Kernel.bind`; None if checks surround it."""
    call: BoundCall | None = getattr(bound, "machine_call", None)
    return call


class Kernel:
    """A function on records, with all it calls: `plain` as it is, `function` as machine code.

    `layouts` are those of the record classes in its annotations. The machine code takes the
    function's parameters one by one; a sequence is two, its address and its length.
    """

    def __init__(
        self, name: str, entry: Callable[..., object], layouts: Mapping[type, RecordLayout[Any]]
    ) -> None:
        assert isinstance(entry, FunctionType)
        self.name = name
        self._entry = entry
        self.layouts = layouts
        self._codes: dict[bool, Callable[..., Any]] = {}
        self._block: Callable[[Any], Any] | None = None
        """The machine code that takes its arguments from a block."""

    @cached_property
    def plain(self) -> Callable[..., Any]:
        """The function as it is."""
        if merges:
            for _, each in list(reached(self._entry)):
                if isinstance(each, FunctionType):
                    merge_steps(each)
        fold_members(self._entry)
        return self._entry

    @property
    def path(self) -> Path:
        """The file of the machine code in the cache, whether it is there or not."""
        return self._object(_checked).path

    @property
    def cached(self) -> bool:
        """True if the machine code is in the cache; compiling takes about two seconds."""
        return compiler_installed() and self.path.exists()

    @cached_property
    def available(self) -> bool:
        """True if there can be machine code: a compiler, and sources to compile; if not, logged."""
        if not compiler_installed():
            _LOG.info("the %s kernel runs as plain Python: no compiler may be used", self.name)
            return False
        try:
            _ = self._digest
        except Exception as error:  # whatever keeps it away, the plain kernel does the same
            _LOG.warning("the %s kernel runs as plain Python: %s", self.name, error)
            return False
        return True

    @property
    def function(self) -> Callable[..., Any]:
        """The machine code, from the cache or compiled now."""
        code = self._codes.get(_checked)
        if code is None:
            code = self._codes[_checked] = self._load(_checked)
        return code

    def bind(self, *arguments: float) -> Callable[..., Any]:
        """Return the machine code with its first arguments.

        They are in a block of memory, so that a call hands over one address.
        """
        function: Any = self.function
        kinds = getattr(function, "argtypes", None)
        if kinds is None:
            return partial(function, *arguments)
        assert self._block is not None
        return _bound(self._block, kinds, arguments)

    def _load(self, checked: bool) -> Callable[..., Any]:
        from achse.native.kernels.sites import Sites
        from achse.native.kernels.translate import BOUND, ENTRY, interface_of, translate

        cache = self._object(checked)
        content = cache.load()
        if content is None:
            module = translate(self._entry, self.layouts, checked=checked)
            content = compile_module(module, Effort.FAST if checked else Effort.FULL)
            cache.save(content)
        code = MachineCode(content, interface_of(self._entry, self.layouts, checked=checked))
        if not checked:
            plain: Callable[..., Any] = code.plain_function(ENTRY)
            self._block = code.plain_function(BOUND)
            return plain
        raw, sites = code.function(ENTRY), Sites(code.notes)

        def function(*arguments: Any) -> Any:
            try:
                return raw(*arguments)
            except MachineFault as fault:
                raise sites[fault.number].exception(fault.first, fault.second) from None

        return function

    def _object(self, checked: bool) -> ObjectCache:
        return ObjectCache(self.name + ("-checked" if checked else ""), self._digest)

    @cached_property
    def _digest(self) -> str:
        from achse.native.kernels.translate import source_of

        digest = hashlib.sha256(identity().encode())
        for layout in _layouts(self.layouts.values()):
            digest.update(f"{layout.name} {layout.words}".encode())
            for name, slot in layout.fields.items():
                digest.update(f"{name} {slot.offset} {slot.length} {slot.is_real}".encode())
                other = slot.refers or slot.holds
                if other is not None:
                    digest.update(f"{other.name} {slot.holds is other}".encode())
        digest.update(self._entry.__qualname__.encode())
        sources: dict[str, FunctionType] = {}
        enums: set[EnumMeta] = set()
        for name, thing in reached(self._entry):
            if isinstance(thing, FunctionType):
                sources.setdefault(thing.__code__.co_filename, thing)
            elif isinstance(thing, EnumMeta):
                if thing not in enums:  # many functions refer to the same
                    enums.add(thing)
                    digest.update(repr(list(thing)).encode())
            elif _is_number(thing):
                digest.update(f"{name} {thing!r}".encode())
        for file in sorted(sources):
            digest.update(source_of(sources[file]).encode())
        digest.update(_compiler_digest())
        return digest.hexdigest()[:20]


def _bound(
    function: Callable[[Any], Any], kinds: Sequence[Any], arguments: Sequence[float]
) -> Callable[..., Any]:
    """Return a function of the last arguments; the first are in a block with room for all."""
    words = array("q", bytes(8 * len(kinds)))
    place = ctypes.c_void_p(words.buffer_info()[0])
    floats = memoryview(words).cast("B").cast("d")
    views: list[Any] = [floats if kind is ctypes.c_double else words for kind in kinds]
    for n, argument in enumerate(arguments):
        views[n][n] = argument
    first = len(arguments)
    run = partial(function, place)
    address = ctypes.cast(function, ctypes.c_void_p).value  # type: ignore[arg-type]
    assert address is not None
    last_view: Any = views[-1] if views else words

    def run_with(last: float) -> Any:
        last_view[first] = last
        return function(place)

    def run_with_several(*last: float) -> Any:
        for n, argument in enumerate(last, first):
            views[n][n] = argument
        return function(place)

    missing = len(kinds) - first
    bound: Any = run if missing == 0 else run_with if missing == 1 else run_with_several
    bound.machine_call = BoundCall(address, words)  # the words stay where they are
    called: Callable[..., Any] = bound
    return called


def _compiler_digest() -> bytes:
    """Return a hash of our own part in what comes out: front and back end."""
    from achse.native import backend, kernels

    digest = hashlib.sha256()
    for room in (backend, kernels):
        folder: Any = Path(room.__path__[0])
        if not folder.is_dir():  # in a zip
            from importlib import resources

            folder = resources.files(room)
        for file in sorted(folder.iterdir(), key=lambda file: str(file.name)):
            if file.name.endswith(".py"):
                digest.update(file.read_bytes())
    return digest.digest()


def _layouts(layouts: Iterable[RecordLayout[Any]]) -> Iterator[RecordLayout[Any]]:
    """Yield the layouts and those that their fields refer to or hold, each once."""
    known: set[RecordLayout[Any]] = set()
    waiting = list(layouts)
    while waiting:
        layout = waiting.pop(0)
        if layout not in known:
            known.add(layout)
            yield layout
            others = (slot.refers or slot.holds for slot in layout.fields.values())
            waiting += [other for other in others if other is not None]


def _is_number(thing: object) -> bool:
    if isinstance(thing, tuple):
        return all(_is_number(part) for part in thing)
    return isinstance(thing, int | float)
