"""PLC libraries as Structured Text: a library is a folder, adding one is adding files.

What needs the system itself is declared with attribute `builtin`, without body; a Python function
of the same name in `achse.plc.routines.builtins`, or in the device that serves it, does it.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files

__all__ = ["names", "sources"]


@cache
def names() -> Sequence[str]:
    """Return the names of the library folders, in lower case; the package is listed once."""
    folders = files(__package__).iterdir()
    return tuple(sorted(item.name for item in folders if _is_library(item.name)))


def sources() -> Iterator[tuple[str, str]]:
    """All files in a fixed order: `tc2_standard/timers.st` and its text."""
    for library in names():
        folder = files(__package__) / library
        for item in sorted(folder.iterdir(), key=lambda item: item.name):
            if item.name.endswith(".st"):
                yield f"{library}/{item.name}", item.read_text(encoding="utf-8")


def _is_library(name: str) -> bool:
    return "." not in name and not name.startswith("_")
