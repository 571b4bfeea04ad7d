"""Options that several commands share."""

from typing import Annotated

import typer

__all__ = ["Count", "CycleTime", "Duration", "LetEverybodyIn", "Watch"]

Watch = Annotated[bool, typer.Option("--watch", "-w", help="Show it live until Ctrl-C.")]

CycleTime = Annotated[
    float,
    typer.Option(
        "--cycle-time", "-c", min=0.001, max=429, help="With --watch: seconds between samples."
    ),
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

LetEverybodyIn = Annotated[
    bool,
    typer.Option("--let-everybody-in", help="Allow an address that other computers reach."),
]
