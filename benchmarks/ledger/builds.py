"""The build that figures belong to: Python, libraries and Valgrind, of which each changes them.

Figures of one build say nothing of another's. A build is known by eight digits, a hash of its
parts; `builds.tsv` says what they stand for.
"""

import hashlib
import platform
import subprocess
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

__all__ = ["Build", "this_build"]

_PACKAGES = ("click", "llvmlite", "pydantic", "pydantic-core", "rich", "typer")
_INSTRUCTIONS = ("abm", "avx2", "bmi1", "bmi2", "f16c", "rdrand", "rdseed")
"""Extensions of the processor that Valgrind passes on, and libraries use."""


class Build:
    """Parts of a build by name."""

    def __init__(self, parts: Mapping[str, str]) -> None:
        self.parts = dict(parts)

    @property
    def key(self) -> str:
        """Eight hexadecimal digits."""
        text = "\n".join(f"{name} {part}" for name, part in sorted(self.parts.items()))
        return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()

    def differences(self, other: "Build") -> list[str]:
        """Return what another build has instead."""
        names = sorted(self.parts.keys() | other.parts.keys())
        pairs = ((name, self.parts.get(name, "-"), other.parts.get(name, "-")) for name in names)
        return [f"{name} {here}, not {there}" for name, here, there in pairs if here != there]

    @classmethod
    def parse(cls, line: str) -> "Build":
        """Return the build of a line of `builds.tsv`, behind its key."""
        return cls(dict(part.split(" ", 1) for part in line.rstrip("\n").split("\t")[1:]))

    def line(self) -> str:
        """Return the line of `builds.tsv`."""
        return "\t".join([self.key, *(f"{name} {part}" for name, part in self.parts.items())])


def this_build() -> Build:
    """Return the build that runs, with the Valgrind that is installed."""
    valgrind = subprocess.run(["valgrind", "--version"], capture_output=True, text=True, check=True)
    parts = {
        "python": f"{platform.python_version()} {platform.python_compiler()}",
        "libc": " ".join(platform.libc_ver()),
        "valgrind": valgrind.stdout.strip(),
        "processor": " ".join([platform.machine(), *_extensions()]),
    }
    return Build(parts | {name: _version(name) for name in _PACKAGES})


def _extensions() -> list[str]:
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8").partition("\n\n")[0]
    flags = next((line.split() for line in text.splitlines() if line.startswith("flags")), [])
    return [name for name in _INSTRUCTIONS if name in flags]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "-"
