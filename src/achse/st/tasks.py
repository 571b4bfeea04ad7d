"""Tasks as files declare them.

Source: `.TcTTO` files of public projects.
"""

from typing import NamedTuple

__all__ = ["FileTask"]


class FileTask(NamedTuple):
    """A task; `programs` only if the file tells."""

    name: str
    cycle_ns: int = 10_000_000
    priority: int = 20
    programs: tuple[str, ...] = ()
    watchdog_cycles: int = 0
    port: int = 0
