"""The command line: `achse run` starts a station, `achse ads` and `achse axis` talk to one."""

import os
import sys

__all__ = ["main", "open_standard_streams"]


def main() -> None:
    """Console script `achse`; ends the process with the command's exit code."""
    open_standard_streams()
    from achse.cli.app import app

    app(prog_name="achse")


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
