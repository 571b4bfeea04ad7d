"""The compiled kernel: its cache and what it translates."""

import subprocess
import sys
from pathlib import Path
from types import FunctionType

import numpy
import pytest

from achse.motion import compiled, kernel, setpoint
from achse.motion.record import record_dtype


def test_the_cache_is_keyed_by_kernel_and_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", "/cache")
    here = compiled.cache_directory("1.0")
    assert here.parent == Path("/cache")
    assert compiled.cache_directory("1.0") == here
    assert compiled.cache_directory("1.1") != here
    monkeypatch.setattr(compiled, "KERNEL_MODULES", compiled.KERNEL_MODULES[:-1])
    assert compiled.cache_directory("1.0") != here


def test_the_cache_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ACHSE_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert compiled.cache_directory("1.0").parent == Path("/xdg/achse")


def test_callees_stand_before_their_callers() -> None:
    """So that each function finds its callees translated already."""
    known: set[str] = set()
    for module in compiled.KERNEL_MODULES:
        own = {
            name: value
            for name, value in vars(module).items()
            if isinstance(value, FunctionType) and value.__module__ == module.__name__
        }
        for name, value in vars(module).items():
            if isinstance(value, FunctionType) and name not in own:
                assert value.__module__ + "." + name in known
        known |= {f"{module.__name__}.{name}" for name in own}


def test_the_plain_kernel_stays_plain() -> None:
    compiled.compiled_cycle()
    assert isinstance(kernel.cycle_all, FunctionType)
    assert isinstance(setpoint.plan, FunctionType)


def test_an_empty_row_of_axes_is_no_work() -> None:
    compiled.compiled_cycle()(numpy.zeros(0, record_dtype()), 0.002)


def test_an_unwritable_cache_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError

    monkeypatch.setattr(Path, "mkdir", refuse)
    directory = compiled.install(Path("/proc/none"))
    assert {path.name for path in directory.glob("*.py")} >= {"kernel.py", "profile.py"}


def test_motion_needs_neither_numpy_nor_numba() -> None:
    script = (
        "import sys; sys.modules['numpy'] = sys.modules['numba'] = None\n"
        "from achse.motion import AxisParameters, Nc, commands\n"
        "nc = Nc(2_000_000, [AxisParameters(1)]); nc.cycle(); print(len(nc.digest()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "16\n"
