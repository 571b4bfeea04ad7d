"""The cache of object files."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.native.backend.cache import ObjectCache, cache_directory


def test_what_was_saved_is_loaded() -> None:
    saved = ObjectCache("pump", "0123")
    assert saved.load() is None
    saved.save(b"code")
    assert ObjectCache("pump", "0123").load() == b"code"
    assert ObjectCache("pump", "0124").load() is None


def test_the_cache_stays_small_and_keeps_what_is_used(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("achse.native.backend.cache._LARGEST", 3000)
    folder = cache_directory()
    results = [ObjectCache("old", str(number)) for number in range(3)]
    for age, one in zip((300, 200, 100), results, strict=True):
        one.save(bytes(900))
        os.utime(one.path, (time.time() - age,) * 2)
    own, abandoned, fresh = folder / "mine.txt", folder / "a.part", folder / "b.part"
    for path in (own, abandoned, fresh):
        path.write_bytes(bytes(5000))
        os.utime(path, (1, 1) if path is not fresh else None)
    assert results[0].load() == bytes(900)
    ObjectCache("new", "1").save(bytes(900))
    assert results[0].load() is not None, "it was used"
    assert results[1].load() is None
    assert own.exists(), "it is not ours"
    assert fresh.exists(), "somebody writes it"
    assert not abandoned.exists()
    large = ObjectCache("large", "1")
    large.save(bytes(9000))
    assert large.load() == bytes(9000)
    assert [path.name for path in folder.glob("*.o")] == [large.path.name]


_PROCESS = """
import sys
from achse.native.backend import cache
cache._LARGEST = 40_000
for number in range(60):
    code = bytes([number]) * 3000
    one = cache.ObjectCache("shared", str(number % 20))
    content = one.load()
    assert content is None or (len(content) == 3000 and content == content[:1] * 3000), content
    one.save(code)
"""


def test_processes_share_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "cache"))
    running = [subprocess.Popen([sys.executable, "-c", _PROCESS]) for _ in range(3)]
    assert [one.wait() for one in running] == [0, 0, 0]
    folder = cache_directory()
    assert sum(path.stat().st_size for path in folder.glob("shared-*.o")) <= 40_000
    assert not list(folder.glob("*.part"))


def test_a_broken_file_counts_for_nothing() -> None:
    saved = ObjectCache("pump", "4567")
    saved.save(b"machine code")
    saved.path.write_bytes(saved.path.read_bytes()[:-2])
    assert saved.load() is None


def test_a_cache_that_cannot_be_written_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", os.path.join(os.devnull, "none"))
    saved = ObjectCache("pump", "89")
    saved.save(b"code")
    assert saved.load() is None


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o775, 0o702])
def test_a_folder_that_others_may_write_to_is_not_used(
    folder: Path, mode: int, caplog: pytest.LogCaptureFixture
) -> None:
    """Before, anyone who could write there ran code with our rights."""
    saved = ObjectCache("pump", "ab")
    saved.save(b"code")
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(mode)
    assert saved.load() is None
    assert f"not loaded: others may write to {folder}, its mode is {mode:o}" in caplog.text
    saved.path.unlink()
    saved.save(b"code")
    assert not saved.path.exists()


def test_a_file_that_others_may_write_to_is_not_loaded(folder: Path) -> None:
    saved = ObjectCache("pump", "cd")
    saved.save(b"code")
    saved.path.chmod(0o666)
    assert saved.load() is None


@pytest.mark.parametrize("whose", ["folder", "file"])
def test_a_file_of_another_user_is_not_loaded(
    folder: Path,
    whose: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    saved = ObjectCache("pump", "ef")
    saved.save(b"code")
    theirs = folder if whose == "folder" else saved.path
    stat, fstat = Path.stat, os.fstat

    def told_of_open(handle: int) -> os.stat_result:
        facts = list(fstat(handle))
        facts[4] += whose == "file"
        return os.stat_result(facts)

    def owner_of(path: Path, **how: bool) -> os.stat_result:
        facts = list(stat(path, **how))
        if path == theirs:
            facts[4] = os.getuid() + 1
        return os.stat_result(facts)

    monkeypatch.setattr(Path, "stat", owner_of)
    monkeypatch.setattr(os, "fstat", told_of_open)
    assert saved.load() is None
    assert f"{theirs} belongs to user {os.getuid() + 1}" in caplog.text


def test_the_cache_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", "/cache")
    assert cache_directory() == Path("/cache")
    monkeypatch.delenv("ACHSE_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache_directory() == Path("/xdg/achse")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == Path.home() / ".cache" / "achse"


def test_a_folder_that_may_not_be_entered_does_not_matter(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a container whose user has the home of another."""
    saved = ObjectCache("pump", "01")
    saved.save(b"code")

    def refusing(method: Callable[..., Any]) -> Callable[..., Any]:
        def call(path: Path, *values: Any, **named: Any) -> Any:
            if path.is_relative_to(saved.path.parent):
                raise PermissionError(13, "Permission denied")
            return method(path, *values, **named)

        return call

    for name in ("stat", "open"):
        monkeypatch.setattr(Path, name, refusing(getattr(Path, name)))
        assert saved.load() is None
