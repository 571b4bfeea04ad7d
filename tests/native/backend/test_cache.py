"""The cache of object files."""

import os
from pathlib import Path

import pytest

from achse.native.backend.cache import ObjectCache, cache_directory


def test_what_was_saved_is_loaded() -> None:
    saved = ObjectCache("pump", "0123")
    assert saved.load() is None
    saved.save(b"code")
    assert ObjectCache("pump", "0123").load() == b"code"
    assert ObjectCache("pump", "0124").load() is None


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
def test_what_belongs_to_somebody_else_is_not_loaded(
    folder: Path,
    whose: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    saved = ObjectCache("pump", "ef")
    saved.save(b"code")
    theirs = folder if whose == "folder" else saved.path
    stat = Path.stat

    def told(path: Path, **how: bool) -> os.stat_result:
        facts = list(stat(path, **how))
        if path == theirs:
            facts[4] = os.getuid() + 1
        return os.stat_result(facts)

    monkeypatch.setattr(Path, "stat", told)
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
