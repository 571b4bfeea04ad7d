"""The linker: what emitted code refers to by name, and where it is."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.plc.code.placement import Placement
from achse.plc.memory import Area
from achse.st.typed.project import Routine, TypedBlock, TypedProject, TypedRecord

__all__ = ["Linker", "LiveRecord", "Probe"]


class LiveRecord(NamedTuple):
    """Lifecycle of a record: keys of its routines, empty where none is needed."""

    create: str
    exit: str
    reinit: str
    number: int
    """Of a function block; 0 of a structure."""
    after_init: tuple[str, ...]


def _live(record: TypedRecord) -> LiveRecord:
    return LiveRecord(
        record.create,
        record.exit,
        record.reinit,
        record.number if isinstance(record, TypedBlock) else 0,
        record.after_init if isinstance(record, TypedBlock) else (),
    )


class Probe(Protocol):
    """Marks in code for a debugger, as pieces of Python."""

    def statement(self, routine: Routine, at: int) -> tuple[str, ...]:
        """Lines that a statement begins with."""
        ...

    def entry(self, routine: Routine) -> str:
        """Return the expression that a call begins with, once `f` is the offset of its frame; makes
        `call`."""
        ...


class Linker:
    """Names in emitted code: `R12` is a routine, `K7` a constant. Both stay as they are."""

    stack = Area.STACK

    def __init__(
        self, project: TypedProject, placement: Placement, *, exceptions: bool = True
    ) -> None:
        self.project = project
        self.probe: Probe | None = None
        """Of a debug build: what code says before each statement."""
        self.exceptions = exceptions
        """The task option "floating point exceptions"."""
        self.placement = placement
        self.constants: dict[str, Any] = {}
        self._names: dict[str, str] = {}
        self._constant_names: dict[Any, str] = {}
        self._rows = {
            record.type.name.lower(): _live(record)
            for record in (*project.blocks.values(), *project.records.values())
        }

    def routine(self, key: str) -> Routine | str:
        """A routine; or, in words, why there is none."""
        found = self.project.routines.get(key)
        if found is not None:
            return found
        return f"{key}: {self.project.left_out.get(key, 'it has an error')}"

    def name_of(self, key: str) -> str:
        """The Python name of a routine."""
        name = self._names.get(key)
        if name is None:
            name = self._names[key] = f"R{len(self._names)}"
        return name

    @property
    def names(self) -> Mapping[str, str]:
        """Python names of all routines that something refers to, by key."""
        return self._names

    def constant(self, value: Any) -> str:
        """The name of something that is not a literal of Python."""
        key = (type(value), id(value) if isinstance(value, IecType | dict) else repr(value))
        name = self._constant_names.get(key)
        if name is None:
            name = self._constant_names[key] = f"K{len(self._constant_names)}"
            self.constants[name] = value
        return name

    def record(self, type: StructType[Any]) -> LiveRecord | None:
        """The row of a record whose values come to life; None if nothing is to be done."""
        return self._rows.get(type.name.lower())
