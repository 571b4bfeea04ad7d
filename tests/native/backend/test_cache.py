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


def test_the_cache_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", "/cache")
    assert cache_directory() == Path("/cache")
    monkeypatch.delenv("ACHSE_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache_directory() == Path("/xdg/achse")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == Path.home() / ".cache" / "achse"
