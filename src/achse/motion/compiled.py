"""The kernel compiled: the same source, loaded a second time and translated by Numba.

Numba's cache belongs to a source file, so the kernel modules are copied into a user cache directory
whose name is a hash of their text, of the record layout and of the Numba version. A changed kernel
is a new directory; a stale one is never used. ACHSE_CACHE_DIR moves the cache.
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
from typing import Any

from achse.motion import (
    controller,
    discrete,
    drive,
    encoder,
    kernel,
    monitoring,
    profile,
    setpoint,
)
from achse.motion.record import FIELDS

__all__ = ["KERNEL_MODULES", "cache_directory", "compiled_cycle", "install", "numba_installed"]

KERNEL_MODULES: tuple[ModuleType, ...] = (
    profile,
    setpoint,
    encoder,
    controller,
    drive,
    discrete,
    monitoring,
    kernel,
)
"""The kernel's modules, callees before callers."""

_ENTRY = "cycle_all"

_OF_ENTRY: dict[str, Any] = {"cache": True}
_OF_CALLEES: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Only the entry is called from Python and kept; callees compile faster without wrappers."""


def numba_installed() -> bool:
    """Whether NumPy and Numba can be imported, without importing them."""
    return all(importlib.util.find_spec(name) is not None for name in ("numpy", "numba"))


def cache_directory(numba_version: str) -> Path:
    """Where this kernel's copies and machine code live."""
    digest = hashlib.sha256(f"{sys.implementation.cache_tag} {numba_version}".encode())
    for module in KERNEL_MODULES:
        digest.update(_source(module))
    for row in FIELDS.values():
        digest.update(f"{row.name} {row.words} {row.is_real}".encode())
    base = os.environ.get("ACHSE_CACHE_DIR")
    if base is None:
        base = os.path.join(
            os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache"),
            "achse",
        )
    return Path(base) / f"kernel-{digest.hexdigest()[:20]}"


def _source(module: ModuleType) -> bytes:
    assert module.__file__ is not None
    return Path(module.__file__).read_bytes()


def install(directory: Path) -> Path:
    """Copy the kernel's sources to `directory`, or to a temporary one if it cannot be written."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        probe_file, probe = tempfile.mkstemp(dir=directory)
        os.close(probe_file)
        os.unlink(probe)
    except OSError:
        directory = Path(tempfile.mkdtemp(prefix="achse-kernel-"))
    for module in KERNEL_MODULES:
        target = directory / f"{_short_name(module)}.py"
        if not target.exists():
            handle, temporary = tempfile.mkstemp(dir=directory)
            with os.fdopen(handle, "wb") as copy:
                copy.write(_source(module))
            with suppress(OSError):
                os.replace(temporary, target)
    return directory


def _short_name(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


@cache
def compiled_cycle() -> Callable[[Any, float], None]:
    """`kernel.cycle_all` for a record array, in machine code; imports Numba.

    The first call with a record array compiles (seconds) or loads the cached code (milliseconds).
    """
    import numba

    directory = install(cache_directory(numba.__version__))
    plain_modules = {module.__name__ for module in KERNEL_MODULES}
    translated: dict[tuple[str, str], Any] = {}
    for module in KERNEL_MODULES:
        name = f"{__name__}.{_short_name(module)}"
        spec = importlib.util.spec_from_file_location(name, directory / f"{_short_name(module)}.py")
        assert spec is not None
        assert spec.loader is not None
        copy = importlib.util.module_from_spec(spec)
        sys.modules[name] = copy  # where unpickling a cached signature looks
        spec.loader.exec_module(copy)
        for symbol, value in list(vars(copy).items()):
            if not isinstance(value, FunctionType):
                continue
            if value.__module__ == name:
                function = numba.njit(**(_OF_ENTRY if symbol == _ENTRY else _OF_CALLEES))(value)
                translated[module.__name__, symbol] = function
                setattr(copy, symbol, function)
            elif value.__module__ in plain_modules:
                setattr(copy, symbol, translated[value.__module__, symbol])
    entry: Callable[[Any, float], None] = translated[kernel.__name__, _ENTRY]
    return entry
