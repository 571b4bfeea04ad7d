"""`achse lsp` serves an editor: findings, hover, completion and rename for PLC sources."""

import sys
from typing import BinaryIO, cast

import typer

from achse.cli.failure import fail


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(lsp)


def lsp() -> None:
    """Serve the editor that started this program by the Language Server Protocol.

    Speaks over standard input and output until the editor goes; the log is on standard error.
    Options come from the editor: `libraries` and `defines` in initializationOptions, or a
    station.toml in its folder.
    """
    try:
        from achse.lsp.server import BoundedInput, MessageTooLong, new_server
    except ModuleNotFoundError:
        from achse.extras import needs_extra

        fail(needs_extra("achse lsp", "lsp"))
    out = sys.stdout.buffer
    sys.stdout = sys.stderr  # printed text would be taken for a message
    from achse import __version__
    from achse.cli.logs import LogFormat, LogLevel, set_up_logs

    set_up_logs(LogFormat.TEXT, LogLevel.WARNING)  # many clients do not read it
    try:
        new_server(__version__).start_io(cast("BinaryIO", BoundedInput(sys.stdin.buffer)), out)
    except MessageTooLong as refusal:
        fail(str(refusal))
