"""Options that several commands share; those of a target are in `achse.cli.target`."""

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from achse.cli.logs import LogFormat, LogLevel

Watch = Annotated[bool, typer.Option("--watch", "-w", help="Show it live until Ctrl-C.")]

CycleTime = Annotated[
    float, typer.Option("--cycle-time", "-c", min=0.001, max=429, help="Between samples, s.")
]

Count = Annotated[
    int | None,
    typer.Option("--count", "-n", min=1, help="End after so many.", show_default="Ctrl-C"),
]

Duration = Annotated[
    float | None,
    typer.Option(
        "--for", metavar="SECONDS", min=0, help="End after this time.", show_default="Ctrl-C"
    ),
]

Acceleration = Annotated[float, typer.Option(help="Units/s²; 0 = that of the axis.")]
Deceleration = Acceleration
Jerk = Annotated[float, typer.Option(help="Units/s³; 0 = that of the axis.")]

Cyclic = Annotated[
    bool, typer.Option("--cyclic", help="The table of the file goes on from its end.")
]

Library = Annotated[
    list[Path] | None,
    typer.Option(
        help="Sources of a library that the project uses, or a folder of libraries; once for each."
    ),
]

TestedProject = Annotated[
    Path,
    typer.Argument(
        help="A folder with PLC sources, a .plcproj, one source file, or a station.toml.",
        show_default=False,
    ),
]

ListenHost = Annotated[
    str | None,
    typer.Option(
        envvar="ACHSE_HOST", help="Address to listen on, or ADDRESS:PORT.", show_default="127.0.0.1"
    ),
]

ListenPort = Annotated[
    int | None,
    typer.Option(
        envvar="ACHSE_TCP_PORT",
        min=0,
        max=65535,
        help="TCP port to listen on, 0 for a free one.",
        show_default="48898",
    ),
]

Logged = Annotated[LogLevel, typer.Option(help="What is logged.")]
LoggedAs = Annotated[LogFormat, typer.Option(help="Log lines, or a JSON document each.")]

SaveTo = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="Save it here.", dir_okay=False),
]

ReadyWithin = Annotated[
    float, typer.Option(min=0.1, help="With --detach: seconds until it must be ready.")
]
EndWithin = Annotated[float, typer.Option(min=0.0, help="Seconds until it must have ended.")]

LetEverybodyIn = Annotated[
    bool,
    typer.Option(
        "--let-everybody-in",
        help="Allow an address that other computers reach: they may do anything, no password.",
    ),
]

Plc = Annotated[
    int,
    typer.Option(min=0, max=65535, help="AMS port of the PLC.", show_default="the first one"),
]
"""The PLC of a station."""

Sources = Annotated[
    Path,
    typer.Argument(
        help="A folder with PLC sources, a .plcproj, one source file.", show_default=False
    ),
]
"""The sources of a PLC project."""


def set_parameters(run: Callable[..., Any], parameters: Sequence[inspect.Parameter]) -> None:
    """Let Typer see these parameters instead of those that `run` is written with."""
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {each.name: each.annotation for each in parameters}
