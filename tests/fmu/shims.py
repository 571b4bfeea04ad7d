"""Compiled shims that are kept: units of equal sources need the C compiler once.

`with kept_shims():` lets `export` take the library of an earlier test or run. Where CC names a
compiler, and in tests of the compilation itself, all is compiled.
"""

import hashlib
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import pytest

from achse.fmu import compiler

__all__ = ["kept_shims"]

FOLDER = Path(__file__).parents[2] / ".pytest_cache" / "shims"


def compile_once(folder: Path, output: Path) -> None:
    """As `compile_shim`."""
    result = shutil.which("cc")
    if os.environ.get("CC") or result is None:
        compiler.compile_shim(folder, output)
        return
    digest = hashlib.sha256(f"{result} {Path(result).stat().st_mtime_ns}".encode())
    for file in (Path(compiler.__file__), *sorted(folder.glob("*.[ch]"))):
        digest.update(b"%s\0%s\0" % (file.name.encode(), file.read_bytes()))
    stored = FOLDER / digest.hexdigest()
    if not stored.exists():
        compiler.compile_shim(folder, output)
        FOLDER.mkdir(parents=True, exist_ok=True)
        begun = stored.with_suffix(f".{os.getpid()}")
        shutil.copyfile(output, begun)
        begun.replace(stored)
    shutil.copyfile(stored, output)


@contextmanager
def kept_shims() -> Iterator[None]:
    """Units of equal sources have the same library."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("achse.fmu.export"), "compile_shim", compile_once)
        yield
