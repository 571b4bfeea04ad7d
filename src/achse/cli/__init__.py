"""The command line: `achse run` starts a station, `achse ads` and `achse axis` talk to one."""

__all__ = ["main"]


def main() -> None:
    """Console script `achse`; ends the process with the command's exit code."""
    from achse.cli.app import app

    app(prog_name="achse")
