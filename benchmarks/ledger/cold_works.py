"""Works that a fresh process does once: imports, help, a check, the start of a station.

What this module imports is not part of the figures, so it imports what Python itself has loaded.
"""

import io
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    Call = Callable[[], object]

PROJECT = """PROGRAM MAIN
VAR
    n : INT;
    t : TON;
END_VAR
t(IN := n < 10, PT := T#1s);
IF t.Q THEN
    n := n + 1;
END_IF
END_PROGRAM
"""


def import_achse() -> "Call":
    """Set up the import of the package."""

    def load() -> None:
        import achse  # noqa: F401

    return load


def _command(*arguments: str) -> "Call":
    """Return a run of a command whose output is dropped."""

    def run() -> None:
        sys.argv = ["achse", *arguments]
        sys.stdout = printed = io.StringIO()
        from achse.cli import main

        try:
            main()
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"achse {' '.join(arguments)}: exit code {end.code}") from end
        assert printed.getvalue(), f"achse {' '.join(arguments)} printed nothing"

    return run


def show_help() -> "Call":
    """Set up `achse --help`."""
    return _command("--help")


def check_project() -> "Call":
    """Set up `achse check` of a folder with one program."""
    os.makedirs("project", exist_ok=True)
    with open("project/main.st", "w", encoding="utf-8") as file:
        file.write(PROJECT)
    return _command("check", "project")


def ready() -> "Call":
    """Set up the start of the demo station, whose time stands still once it is open."""

    async def open_and_close() -> None:
        from achse.station import Station

        async with Station.demo().running("127.0.0.1", 0, speed=0):
            pass

    def start() -> None:
        import asyncio

        asyncio.run(open_and_close())

    return start
