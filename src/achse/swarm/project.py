"""Worlds around the station of a user: operators, clients and faults, and invariants of the user.

The station.toml is taken as it is, its programs too. Files of persistent data are in memory.
"""

import types
from collections.abc import Callable, Sequence
from pathlib import Path

from achse.st.files.forms import Content, has_content
from achse.station import Station
from achse.swarm.st_checks import load_st_checks
from achse.swarm.worlds.drawing import draw_surroundings
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import DrawnAxis, World, WorldError

PROJECT_INVARIANTS = frozenset(("finite", "velocity", "slave-step", "gear-law"))
"""Invariants of motion that hold whatever dynamics the programs of a user command."""

UserCheck = tuple[str, Callable[[Station], str | None]]
"""Name of a function of the user, and the function: it returns what is wrong, or raises."""

_VALUES = (
    "max_velocity", "max_acceleration", "max_deceleration", "default_acceleration",
    "default_deceleration", "default_jerk", "encoder_modulo_factor",
)  # fmt: skip

_GENTLEST = 0.2


def station_file(project: Path) -> Path:
    """Return the station.toml of a project, a folder or the file itself. Raises WorldError."""
    file = project / "station.toml" if project.is_dir() else project
    if not file.is_file():
        raise WorldError(f"expected a station.toml or a folder with one, got {project}")
    return file


def draw_project_world(seed: int, project: Path) -> World:
    """Draw clients and faults around the station of a project. Raises WorldError, ConfigError."""
    file = station_file(project)
    station = Station.load(file)
    nc = station.nc
    if nc is None or not list(nc):
        raise WorldError(f"{file}: expected a station with an axis")
    axes = [
        DrawnAxis(
            axis.name, "", False, {name: float(getattr(axis, name)) for name in _VALUES}, _GENTLEST
        )
        for axis in nc
    ]
    ids = [axis.axis_id for axis in nc]
    if ids != list(range(1, len(ids) + 1)):
        raise WorldError(f"{file}: expected axes with the ids 1, 2, …, got {ids}")
    world = draw_surroundings(seed, Stream(seed, "project"), axes, [], [])
    return World(
        seed=seed,
        length_ns=world.length_ns,
        cycle_ns=nc.cycle_ns,
        axes=axes,
        clients=world.clients,
        acts=world.acts,
        project=str(file),
    )


def load_checks(file: Path) -> Sequence[UserCheck]:
    """Return the functions `check_…` of a Python file, or the BOOL outputs of Structured Text.

    Raises WorldError, OSError.
    """
    if has_content(file, Content.TEXT):
        return load_st_checks(file)
    if file.suffix != ".py":
        raise WorldError(f"expected invariants as a file .py or .st, got {file}")
    module = types.ModuleType("__achse_invariants__")
    module.__file__ = str(file)
    try:
        exec(compile(file.read_text(encoding="utf-8"), str(file), "exec"), module.__dict__)
    except Exception as fault:
        raise WorldError(f"{file}: {type(fault).__name__}: {fault}") from fault
    checks = [
        (name, function)
        for name, function in vars(module).items()
        if name.startswith("check_") and callable(function)
    ]
    if not checks:
        raise WorldError(f"{file}: expected functions check_…(station), got none")
    return checks
