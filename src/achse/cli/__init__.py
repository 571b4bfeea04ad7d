"""The command line: `achse run` starts a station, `achse ads` and `achse axis` talk to one.

Each panel of `achse --help` is a room: `start`, `ads`, `axes`, `programs`, `fieldbus`, `plc`,
`record`, `test` and `install`. Beside them are the root (`app`, `root`, `front`), the base of
client commands (`target`, `options`, `complete`), and the output (`output`, `plot`, `files`,
`failure`, `logs`). Read `target` first, then `ads.ads`, the plainest commands. Modules import what
they need when a command runs.
"""

import errno
import gc
import io
import os
import sys
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from typer import Typer

__all__ = ["main", "open_standard_streams"]

_YOUNG = 300_000
"""New objects until Python looks for garbage: a start makes half as many, and keeps them."""


_ALONE = {
    "run": "achse.cli.start.run",
    "check": "achse.cli.test.check",
    "test": "achse.cli.test.unit_tests",
}
"""Commands that are started often, with their modules."""

_FULL = (errno.ENOSPC, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG)
"""Error codes of a stdout that accepts no more: a full disk, or a closed terminal."""


def main() -> None:
    """Run the console script `achse`; end the process with the command's exit code."""
    gc.set_threshold(_YOUNG)
    from achse.cli.interrupts import leave_at_once

    leave_at_once()
    open_standard_streams()
    from achse.cli.failure import errors_in_json, print_failure, wants_json

    try:
        try:
            _commands(sys.argv[1:])(prog_name="achse")
        finally:
            sys.stdout.flush()  # Python's own at the end gives 120 if it fails
    except BrokenPipeError:  # the reader has ended, as `head` does
        os._exit(1)
    except Exception as defect:
        if isinstance(defect, OSError) and defect.errno in _FULL and defect.filename is None:
            with errors_in_json(wants_json(sys.argv)):
                print_failure(f"cannot write the output: {defect.strerror}", name="CANNOT_WRITE")
            os._exit(1)  # what is left in the buffer would be tried again
        if "ACHSE_DEBUG" in os.environ:
            raise
        with errors_in_json(wants_json(sys.argv)):
            print_failure(
                f"unexpected {type(defect).__name__}: {defect} (a defect of achse, please report"
                " it; with ACHSE_DEBUG=1 in the environment it prints the place)",
                name="DEFECT",
            )
        sys.exit(70)


def _commands(words: list[str]) -> "Typer":
    """Return the commands; one of `_ALONE` without the others, which would delay each start."""
    module = _ALONE.get(words[0]) if words else None
    if module is not None:
        from importlib import import_module

        from achse.cli.root import new_root

        app = new_root()
        import_module(module).register(app)
        return app
    from achse.cli.app import app as every_command

    return every_command


def open_standard_streams() -> None:
    """Let stdin, stdout and stderr that are closed lead nowhere (`achse run 2>&-`, some services).

    Otherwise the next file or socket would have their numbers, and what prints would end there.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
        if getattr(sys, name) is None:
            stream = open(os.devnull, "w" if number else "r", encoding="utf-8")  # noqa: SIM115
            setattr(sys, name, stream)
        _write_anything(getattr(sys, name))


def _write_anything(stream: TextIO) -> None:
    """Escape characters that the encoding does not have (`LC_ALL=C`, cp1252) instead of raising."""
    if isinstance(stream, io.TextIOWrapper) and stream.writable() and stream.errors == "strict":
        stream.reconfigure(errors="backslashreplace")
