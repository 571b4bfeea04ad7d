"""The kernel compiled: the same source, loaded a second time and translated by Numba.

Numba's cache belongs to a source file, so the kernel modules are copied into a user cache directory
whose name is a hash of their text, of the record layout and of the Numba version. ACHSE_CACHE_DIR
moves the cache.
"""

import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from achse.drive import (
    exchange,
    gantry,
    kernel,
    motion,
    plant,
    power,
    probe,
    profile,
    signals,
    supervision,
)
from achse.drive.mapping import ProcessData
from achse.drive.modes import (
    cyclic_position,
    cyclic_torque,
    cyclic_velocity,
    halt,
    homing,
    profile_position,
    profile_torque,
    profile_velocity,
)
from achse.drive.objects import DataType
from achse.drive.record import FIELDS, OFFSETS, DriveFields, record_dtype

__all__ = ["KERNEL_MODULES", "CompiledRecord", "compiled_exchange", "numba_installed"]

KERNEL_MODULES: tuple[ModuleType, ...] = (
    plant,
    profile,
    probe,
    signals,
    gantry,
    supervision,
    power,
    halt,
    profile_position,
    profile_velocity,
    profile_torque,
    homing,
    cyclic_position,
    cyclic_velocity,
    cyclic_torque,
    motion,
    kernel,
    exchange,
)
"""The kernel's modules, callees before callers."""

_ENTRY = "exchange"


def numba_installed() -> bool:
    """Whether NumPy and Numba can be imported, without importing them."""
    return all(importlib.util.find_spec(name) is not None for name in ("numpy", "numba"))


def _source(module: ModuleType) -> bytes:
    assert module.__file__ is not None
    return Path(module.__file__).read_bytes()


def _file(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2] + ".py"


def _cache_directory(numba_version: str) -> Path:
    digest = hashlib.sha256(f"{sys.implementation.cache_tag} {numba_version}".encode())
    for module in KERNEL_MODULES:
        digest.update(_source(module))
    digest.update(repr(FIELDS).encode())
    base = os.environ.get("ACHSE_CACHE_DIR")
    if base is None:
        home = os.path.join(os.path.expanduser("~"), ".cache")
        base = os.path.join(os.environ.get("XDG_CACHE_HOME") or home, "achse")
    return Path(base) / f"drive-{digest.hexdigest()[:20]}"


def _install(directory: Path) -> Path:
    """Copy the sources there, or to a temporary directory if it cannot be written."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        probe_file, name = tempfile.mkstemp(dir=directory)
        os.close(probe_file)
        os.unlink(name)
    except OSError:
        directory = Path(tempfile.mkdtemp(prefix="achse-drive-"))
    for module in KERNEL_MODULES:
        target = directory / _file(module)
        if not target.exists():
            handle, temporary = tempfile.mkstemp(dir=directory)
            with os.fdopen(handle, "wb") as copy:
                copy.write(_source(module))
            with suppress(OSError):
                os.replace(temporary, target)
    return directory


@cache
def compiled_exchange() -> Callable[[Any, Any, float, int, int], int]:
    """`exchange.exchange` for a record array, in machine code; imports Numba.

    The first call with a record array compiles (seconds) or loads the cached code (milliseconds).
    """
    import numba

    directory = _install(_cache_directory(numba.__version__))
    copies: dict[str, ModuleType] = {}
    translated: dict[tuple[str, str], Any] = {}
    for module in KERNEL_MODULES:
        name = f"{__name__}.{_file(module)[:-3]}"
        spec = importlib.util.spec_from_file_location(name, directory / _file(module))
        assert spec is not None
        assert spec.loader is not None
        copy = importlib.util.module_from_spec(spec)
        sys.modules[name] = copy  # where unpickling a cached signature looks
        spec.loader.exec_module(copy)
        copies[module.__name__] = copy
        for symbol, value in list(vars(copy).items()):
            if isinstance(value, ModuleType) and value.__name__ in copies:
                setattr(copy, symbol, copies[value.__name__])
            elif isinstance(value, FunctionType) and value.__module__ == name:
                function = numba.njit(cache=symbol == _ENTRY)(value)
                translated[module.__name__, symbol] = function
                setattr(copy, symbol, function)
            elif isinstance(value, FunctionType) and value.__module__ in copies:
                setattr(copy, symbol, translated[value.__module__, symbol])
    entry: Callable[[Any, Any, float, int, int], int] = translated[exchange.__name__, _ENTRY]
    return entry


if TYPE_CHECKING:

    class _Fields(DriveFields):
        pass

else:

    class _Fields:
        __slots__ = ()


class CompiledRecord(_Fields):
    """A record as one row of an array, for the compiled kernel: the fields are attributes."""

    __slots__ = ("_array", "_inputs", "_kernel", "_outputs", "_reals", "rows", "words")

    def __init__(self) -> None:
        import numpy

        self._kernel = compiled_exchange()
        self.rows = numpy.zeros(1, record_dtype())
        self._array = self.rows.view(numpy.int64)
        self._kernel(self.rows, self._array, 1e-3, 0, 0)  # compiles or loads now, not in a cycle
        data: memoryview = memoryview(self.rows.view("u1").data)
        self._reals = data.cast("d")
        self.words = data.cast("q")
        for name, default in FIELDS.items():
            if isinstance(default, list):
                getattr(self, name)[:] = default
            else:
                setattr(self, name, default)

    def map(self, received: ProcessData, sent: ProcessData) -> bool:
        """Take the mapping over; False if it holds floating-point objects, which go around."""
        self.received_count = self.sent_count = 0
        if any(row.type is DataType.F32 for row in (*received.rows, *sent.rows)):
            return False
        for n, (row, at) in enumerate(zip(received.rows, received.offsets, strict=True)):
            size = row.type.bits // 8
            self.received_word[n] = OFFSETS[row.place]
            self.received_at[n] = at
            self.received_size[n] = -size if row.type.least < 0 else size
        for n, (row, at) in enumerate(zip(sent.rows, sent.offsets, strict=True)):
            self.sent_word[n] = OFFSETS[row.field]
            self.sent_at[n] = at
            self.sent_size[n] = row.type.bits // 8
        self.received_count, self.sent_count = len(received.rows), len(sent.rows)
        data = memoryview(self.words).cast("B")
        first = 8 * OFFSETS["outputs"]
        self._outputs = data[first : first + received.size]
        first = 8 * OFFSETS["inputs"]
        self._inputs = data[first : first + sent.size]
        return True

    def exchange(self, outputs: bytes | None, dt: float, count: int) -> tuple[int, bytes]:
        """`count` cycles with process data both ways; whether it asks for attention, inputs."""
        if outputs is None:
            attention = self._kernel(self.rows, self._array, dt, count, 0)
        else:
            self._outputs[:] = outputs
            attention = self._kernel(self.rows, self._array, dt, count, 1)
        return attention, self._inputs.tobytes()

    def cycles(self, dt: float, count: int) -> None:
        """`count` cycles of `dt` seconds."""
        self._kernel(self.rows, self._array, dt, count, 0)


def _property(name: str, default: Any) -> property:
    first = OFFSETS[name]
    if isinstance(default, list):
        return property(lambda record: record.rows[name][0])
    words = "_reals" if isinstance(default, float) else "words"
    scope: dict[str, Any] = {}
    exec(
        f"def read(record): return record.{words}[{first}]\n"
        f"def write(record, value): record.{words}[{first}] = value\n",
        scope,
    )
    return property(scope["read"], scope["write"])


for _name, _default in FIELDS.items():
    setattr(CompiledRecord, _name, _property(_name, _default))
