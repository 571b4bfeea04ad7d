"""Options, reports and limits that `achse test` and `achse mutate` share."""

import logging
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file

FailUnder = Annotated[
    float | None,
    typer.Option(
        metavar="PERCENT",
        min=0,
        max=100,
        help="End with 1 if the result is lower.",
        show_default=False,
    ),
]

PlcTimeLimit = Annotated[
    float,
    typer.Option(
        metavar="SECONDS", min=0.001, help="PLC time that the tests may take (without a fault)."
    ),
]


def check_endings(option: str, files: Sequence[Path], endings: Collection[str]) -> None:
    """End the command if a report's file has an ending of no form."""
    for file in files:
        if file.suffix.lower() not in endings:
            fail(f"{option}: expected a file that ends in {', '.join(endings)}, got {file}")


@contextmanager
def without_log(silent: bool = True) -> Iterator[None]:
    """Log nothing of the stations that run inside, if `silent`."""
    logger = logging.getLogger("achse")
    before = logger.level
    try:
        if silent:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        logger.setLevel(before)


def write_reports(files: Sequence[Path], report: Callable[[Path], str]) -> None:
    """Write the report of each file; a file that cannot be written ends the command."""
    for file in files:
        write_file(file, report(file).encode())


def reaches(subject: str, percent: float, least: float | None) -> bool:
    """Return True if a result reaches the least; else print both and return False."""
    if least is None or percent >= least:
        return True
    print(f"{subject}: expected at least {least:g}%, got {percent:.1f}%")
    return False
