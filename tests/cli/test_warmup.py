"""Kernels compiled ahead."""

import json
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.drive.compiled import KERNEL as DRIVE
from achse.motion.compiled import KERNEL as MOTION
from achse.native.compiled import Kernel
from achse.native.kernels.translate import TranslationError
from achse.native.sampling import KERNEL as SAMPLING

MODULES = {
    "achse.motion.compiled": MOTION,
    "achse.drive.compiled": DRIVE,
    "achse.native.sampling": SAMPLING,
}


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and nothing loaded yet."""
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path))
    for module, kernel in MODULES.items():
        again = Kernel(kernel.name, kernel.plain, kernel.layouts)
        monkeypatch.setattr(f"{module}.KERNEL", again)
    return tmp_path


def test_it_compiles_once_and_says_so(fresh: Path) -> None:
    done = CliRunner().invoke(app, ["warmup"])
    assert done.exit_code == 0, done.output
    first, second, third = done.stdout.splitlines()
    assert first.startswith("motion kernel: compiled, ")
    assert second.startswith("drive kernel: compiled, ")
    assert third.startswith("sampling kernel: compiled, ")
    names = sorted(path.name.split("-")[0] for path in fresh.iterdir())
    assert names == ["drive", "motion", "sampling"]


def test_it_finds_what_is_compiled_already(fresh: Path) -> None:
    for kernel in MODULES.values():
        _ = Kernel(kernel.name, kernel.plain, kernel.layouts).function
    done = CliRunner().invoke(app, ["warmup", "--json"])
    facts = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(each["kernel"], each["compiled"]) for each in facts] == [
        ("motion", False),
        ("drive", False),
        ("sampling", False),
    ]
    assert all(Path(each["path"]).exists() and each["seconds"] < 1.0 for each in facts)


def test_without_sources_it_says_so(fresh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(function: object) -> str:
        raise TranslationError("not there")

    monkeypatch.setattr("achse.native.kernels.translate.source_of", gone)
    done = CliRunner().invoke(app, ["warmup"])
    assert done.exit_code == 1
    assert "motion kernel: runs as plain Python" in done.output


def test_without_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    done = CliRunner().invoke(app, ["warmup"])
    assert done.exit_code == 1
    assert "pip install 'achse[fast]'" in done.output
