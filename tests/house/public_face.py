"""What users see of achse, one line each: names, commands with their options, keys, faults.

`python -m tests.house.public_face` writes tests/data/public_face.txt anew.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel
from typer.main import get_command

from achse.cli.app import app
from achse.faults.drives import DRIVE_FAULTS
from achse.faults.kinds import STATION_FAULTS
from achse.gateway.configuration import TargetConfig
from achse.station.configuration.station_file import StationConfig

LISTED = Path(__file__).parents[1] / "data" / "public_face.txt"

ROOMS = (
    "achse", "achse.client", "achse.client.blocking", "achse.client.nc", "achse.drive",
    "achse.ethercat", "achse.iec", "achse.plc", "achse.plot", "achse.station", "achse.testing",
)  # fmt: skip
"""Modules whose `__all__` people import from."""


def _names() -> Iterator[str]:
    for room in ROOMS:
        for name in import_module(room).__all__:
            yield f"name {room}.{name}"


def _commands(command: Any, path: str) -> Iterator[str]:
    for name, child in getattr(command, "commands", {}).items():
        yield from _commands(child, f"{path} {name}")
    if not hasattr(command, "commands") or (path != "achse" and command.invoke_without_command):
        yield f"command {path}"
        for parameter in command.params:
            if parameter.param_type_name == "argument":
                yield f"command {path} {parameter.name.upper()}"
            else:
                yield f"command {path} {'/'.join((*parameter.opts, *parameter.secondary_opts))}"


def _section(annotation: Any) -> type[BaseModel] | None:
    """The table that a key holds, or a list of such."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    sections = (_section(part) for part in get_args(annotation))
    return next((section for section in sections if section is not None), None)


def _keys(section: type[BaseModel], path: str) -> Iterator[str]:
    for name, field in section.model_fields.items():
        yield f"key {path}{name}"
        inner = _section(field.annotation)
        if inner is not None:
            yield from _keys(inner, f"{path}{name}.")


def _faults() -> Iterator[str]:
    for family, kinds in (("station", STATION_FAULTS), ("drive", DRIVE_FAULTS)):
        for kind in kinds:
            parameters = " ".join(kinds.parameters(kind))
            yield f"fault {family} {kind} {parameters}".rstrip()


def public_face() -> list[str]:
    """Every line, sorted."""
    lines = (
        *_names(),
        *_commands(get_command(app), "achse"),
        *_keys(StationConfig, ""),
        *_keys(TargetConfig, "target."),
        *_faults(),
    )
    return sorted(set(lines))


if __name__ == "__main__":
    LISTED.write_text("\n".join(public_face()) + "\n", encoding="utf-8")
