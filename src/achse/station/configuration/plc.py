"""[[plc]] of a station.toml, and its tasks."""

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, model_validator

from achse.station.configuration.types import ConfigTable, DurationNs


class TaskConfig(ConfigTable):
    """[[plc.task]]: programs called in order, once per cycle."""

    name: str = "PlcTask"
    cycle: DurationNs = 10_000_000
    priority: int = Field(default=20, ge=0, le=255)
    watchdog_cycles: int = Field(default=0, ge=0, le=1_000_000)
    """After so many cycles in a row that took longer than `cycle` the log warns; 0: never."""
    programs: Sequence[str] = ()
    """Each the name of a declared program, or `module:Class` or `file.py:Class` (relative to the
    station.toml)."""


class PlcConfig(ConfigTable):
    """[[plc]]: one PLC device. Its variables come from `sources`, from `symbols`, or from Python.

    Without `[[plc.task]]` the tasks are those of the project or symbol file.
    """

    port: int = Field(default=851, ge=1, le=65535)
    also: Sequence[Annotated[int, Field(ge=1, le=65535)]] = ()
    """Further ports that answer for the same device, for example 801."""
    sources: str | None = None
    """A folder of Structured Text (`.TcPOU`, `.TcGVL`, `.TcDUT`, `.st` …), or one such file."""
    libraries: Sequence[str] = ()
    """Sources of libraries, folders or files like `sources`, or `.tmc` files with their types; of
    them only what is named counts. Of a folder with several projects those are taken that the
    `.plcproj` references by title."""
    unknown_types: Literal["refuse", "libraries", "opaque"] = "libraries"
    """Handling of types, constants and functions that `sources` name and nothing declares:
    `libraries` makes stubs of those of libraries that the `.plcproj` references and that are not
    here, `opaque` of all, with the members that the sources use; stubs do nothing."""
    execute: bool = True
    """True if the programs of `sources` run; if not, they are declared only."""
    floating_point_exceptions: bool | None = None
    """The task option of that name: a REAL divided by 0, the root of -1 stop the program; if off
    they are infinity and NaN. By default on, but off if the solution of the sources has
    `DisableFpExceptions` at a task."""
    check_bounds: bool = True
    """True if an index outside of its array stops the program; if not, it reads or writes the
    neighbouring bytes, as on a target without CheckBounds. Outside of PLC memory it stops."""
    code: Literal["auto", "machine", "plain"] = "auto"
    """`machine` needs llvmlite (achse[fast]); `auto` takes it where it is there. What programs do
    is the same."""
    coverage: bool | Literal["conditions"] = False
    """True if statements and branches of `sources` count: `achse.plc.coverage` reports them; with
    `conditions` those of its decisions, too (MC/DC)."""
    budget: int = Field(default=5_000_000, ge=1000, le=1_000_000_000)
    """Loop passes and calls that one cycle of `sources` may take; then it is an endless loop, and
    exception CYCLE_TIME_EXCEED stops the PLC."""
    symbols: str | None = None
    """A symbol file, `.tmc` or `.tpy`."""
    behaviour: Sequence[str] = ()
    """Python classes for declared programs and function blocks, `module:Class` or
    `file.py:Class`; each is for the one of its name."""
    globals: Sequence[str] = ()
    """Global variable lists, named like programs."""
    task: Sequence[TaskConfig] = ()

    @model_validator(mode="after")
    def _one_origin(self) -> "PlcConfig":
        if self.sources is not None and self.symbols is not None:
            raise ValueError("either sources or symbols, not both")
        if self.libraries and self.sources is None:
            raise ValueError("libraries go with sources")
        if self.unknown_types != "libraries" and self.sources is None:
            raise ValueError("unknown_types goes with sources")
        return self

    @property
    def has_python(self) -> bool:
        """True if Python classes of the user are part of the PLC."""
        programs = (name for task in self.task for name in task.programs)
        return bool(self.behaviour or self.globals) or any(":" in name for name in programs)
