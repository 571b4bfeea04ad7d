"""Compilation of the shim with the C compiler of the computer."""

import os
import platform
import shlex
import shutil
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

from achse.fmu.errors import ExportError

SHIM_SOURCES = ("unit.c", "process.c", "fmi2.c", "fmi3.c")

_HEADERS = ("unit.h", "process.h", "fmi2.h", "fmi3.h")
_LONGEST_S = 300
_SHOWN = 2000

_ARCHITECTURES = {"amd64": "x86_64", "arm64": "aarch64"}
_FMI2_FOLDERS = {
    ("linux", "x86_64"): "linux64",
    ("linux", "aarch64"): "linux64",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "aarch64"): "darwin64",
}


def shim_files() -> dict[str, bytes]:
    """Return the C files of the shim by name."""
    folder = files("achse.fmu") / "shim"
    return {name: (folder / name).read_bytes() for name in (*SHIM_SOURCES, *_HEADERS)}


def platform_folder(fmi: int) -> str:
    """Return the folder of this platform below `binaries`. Raises ExportError."""
    system = sys.platform
    machine = platform.machine().lower()
    machine = _ARCHITECTURES.get(machine, machine)
    if system not in ("linux", "darwin"):
        raise ExportError(f"platform: expected Linux or macOS for a unit, got {system}")
    if fmi >= 3:
        return f"{machine}-{system}"
    try:
        return _FMI2_FOLDERS[system, machine]
    except KeyError:
        raise ExportError(f"platform: FMI 2.0 has no name for {machine}; use --fmi 3") from None


def binary_name(identifier: str) -> str:
    """Return the file name of the shared library of a model."""
    return identifier + (".dylib" if sys.platform == "darwin" else ".so")


def compile_shim(folder: Path, output: Path) -> None:
    """Compile the C files in a folder into a shared library.

    The compiler is the one that the environment variable CC names, else `cc`. Raises ExportError.
    """
    named = shlex.split(os.environ.get("CC", "")) or ["cc"]
    if shutil.which(named[0]) is None:
        raise ExportError(
            f"C compiler: expected {named[0]!r} in PATH, found none;"
            " install one (Debian: apt install gcc), or name it in CC"
        )
    command = [*named, "-shared", "-fPIC", "-O2", "-o", str(output), *SHIM_SOURCES, "-lm"]
    try:
        ended = subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_LONGEST_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as failure:
        raise ExportError(f"C compiler: {named[0]}: {failure}") from None
    if ended.returncode != 0:
        raise ExportError(f"C compiler: {shlex.join(command)}:\n{ended.stderr[-_SHOWN:]}")
