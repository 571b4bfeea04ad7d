"""Kernels compiled ahead."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.camshaft.kernel import KERNEL as CAMSHAFT
from achse.cli.app import app
from achse.drive.compiled import KERNEL as DRIVE
from achse.extras import needs_extra
from achse.motion.compiled import KERNEL as MOTION
from achse.motion.path.compiled import KERNEL as PATH
from achse.motion.readout.cyclic_image import KERNEL as IMAGES
from achse.motion.servo.compiled import SEND, TAKE
from achse.native.compiled import Kernel
from achse.native.kernels.arithmetic import TranslationError
from achse.native.sampling import KERNEL as SAMPLING
from achse.scope.kernel import KERNEL as SCOPE
from achse.station.buses.whole_cycle import KERNEL as DRIVEN

MODULES = {
    "achse.motion.compiled": MOTION,
    "achse.drive.compiled": DRIVE,
    "achse.native.sampling": SAMPLING,
    "achse.scope.kernel": SCOPE,
    "achse.camshaft.kernel": CAMSHAFT,
    "achse.motion.servo.compiled.TAKE": TAKE,
    "achse.motion.servo.compiled.SEND": SEND,
    "achse.station.buses.whole_cycle": DRIVEN,
    "achse.motion.readout.cyclic_image": IMAGES,
    "achse.motion.path.compiled": PATH,
}

LARGE = (MOTION, DRIVE, DRIVEN, PATH)
"""Kernels that take seconds to compile. A small one has their name here; the other tests compile
them as they are."""


def _start_over(folder: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setenv("ACHSE_CACHE_DIR", str(folder))
    for module, kernel in MODULES.items():
        real = SCOPE if kernel in LARGE else kernel
        again = Kernel(kernel.name, real.plain, real.layouts)
        patch.setattr(module if module.endswith(("TAKE", "SEND")) else f"{module}.KERNEL", again)


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and nothing loaded yet."""
    _start_over(tmp_path, monkeypatch)
    return tmp_path


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """What the command said with an empty cache, and the cache it filled."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        _start_over(folder, patch)
        return CliRunner().invoke(app, ["warmup"]), folder


def test_it_compiles_once_and_says_so(warm: tuple[Result, Path]) -> None:
    done, folder = warm
    assert done.exit_code == 0, done.output
    first, second, third, fourth, fifth, *others = done.stdout.splitlines()
    assert first.startswith("motion kernel: compiled, ")
    assert second.startswith("drive kernel: compiled, ")
    assert third.startswith("sampling kernel: compiled, ")
    assert fourth.startswith("scope kernel: compiled, ")
    assert fifth.startswith("camshaft kernel: compiled, ")
    rest = "servo-inputs", "servo-outputs", "driven-axes", "cyclic-images", "path", "frames"
    for line, name in zip(others, rest, strict=True):
        assert line.startswith(f"{name} kernel: compiled, ")
    names = sorted(path.name.split("-")[0] for path in folder.iterdir())
    assert names == [
        *("camshaft", "cyclic", "drive", "driven", "frames", "motion", "path", "sampling"),
        *("scope", "servo", "servo"),
    ]


def test_it_finds_what_is_compiled_already(warm: tuple[Result, Path], fresh: Path) -> None:
    shutil.copytree(warm[1], fresh, dirs_exist_ok=True)
    done = CliRunner().invoke(app, ["warmup", "--json"])
    facts = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(each["kernel"], each["compiled"]) for each in facts] == [
        ("motion", False),
        ("drive", False),
        ("sampling", False),
        ("scope", False),
        ("camshaft", False),
        ("servo-inputs", False),
        ("servo-outputs", False),
        ("driven-axes", False),
        ("cyclic-images", False),
        ("path", False),
        ("frames", False),
    ]
    assert all(Path(each["path"]).exists() for each in facts)


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
    assert done.output == needs_extra("warmup", "fast") + "\n"
