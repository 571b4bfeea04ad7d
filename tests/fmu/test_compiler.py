"""Compilation of the shim."""

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

from achse.fmu.compiler import (
    SHIM_SOURCES,
    binary_name,
    compile_shim,
    platform_folder,
    shim_files,
)
from achse.fmu.errors import ExportError


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    for name, data in shim_files().items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def test_library_has_both_versions(sources: Path, compiler: str) -> None:
    library = sources / binary_name("cell")
    compile_shim(sources, library)
    loaded = ctypes.CDLL(str(library))
    loaded.fmi3GetVersion.restype = loaded.fmi2GetVersion.restype = ctypes.c_char_p
    assert (loaded.fmi3GetVersion(), loaded.fmi2GetVersion()) == (b"3.0", b"2.0")


def test_shim_compiles_without_a_warning(sources: Path, compiler: str) -> None:
    command = [compiler, "-std=gnu11", "-fPIC", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    subprocess.run([*command, *SHIM_SOURCES], cwd=sources, check=True, capture_output=True)


def test_missing_compiler_is_named(
    sources: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler -O3")
    with pytest.raises(ExportError, match="C compiler: expected 'no-such-compiler' in PATH"):
        compile_shim(sources, tmp_path / "x.so")


def test_failed_compilation_shows_the_compiler_s_words(
    sources: Path, compiler: str, tmp_path: Path
) -> None:
    (sources / "unit.c").write_text("int broken = ;\n")
    with pytest.raises(ExportError, match=r"(?s)C compiler: .*unit\.c:1"):
        compile_shim(sources, tmp_path / "x.so")


@pytest.mark.parametrize(
    ("system", "machine", "fmi", "folder"),
    [
        ("linux", "x86_64", 3, "x86_64-linux"),
        ("linux", "AMD64", 2, "linux64"),
        ("darwin", "arm64", 3, "aarch64-darwin"),
        ("darwin", "arm64", 2, "darwin64"),
    ],
)
def test_folder_is_that_of_the_platform(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, fmi: int, folder: str
) -> None:
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert platform_folder(fmi) == folder


@pytest.mark.parametrize(
    ("system", "machine", "fmi", "complaint"),
    [
        ("win32", "AMD64", 3, "expected Linux or macOS for a unit, got win32"),
        ("linux", "riscv64", 2, "FMI 2.0 has no name for riscv64"),
    ],
)
def test_other_platforms_are_refused(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, fmi: int, complaint: str
) -> None:
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    with pytest.raises(ExportError, match=complaint):
        platform_folder(fmi)
