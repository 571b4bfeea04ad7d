"""The root of the command line, which commands are hung on."""

import json
from typing import Annotated

import typer

from achse.cli.failure import in_json
from achse.cli.front import PANELS, Front


def _print_version(wanted: bool) -> None:
    if wanted:
        from achse import __version__

        print(json.dumps({"version": __version__}) if in_json() else f"achse {__version__}")
        raise typer.Exit


def new_root() -> typer.Typer:
    """Return a root without commands."""
    app = typer.Typer(
        cls=Front,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        help="A motion station: PLC and NC devices with moving axes behind an ADS/AMS router.",
    )
    app.callback()(_root)
    return app


def in_panels(app: typer.Typer) -> None:
    """Put each command of the root into its panel of the help; KeyError for one that has none."""
    panel = {name: title for title, names in PANELS.items() for name in names}
    for infos in (app.registered_commands, app.registered_groups):
        for info in infos:
            callback = getattr(info.callback, "__name__", "")
            info.rich_help_panel = panel[info.name or callback.replace("_", "-")]


def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Handle the options before the command."""
