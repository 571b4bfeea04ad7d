"""The linker: what emitted code refers to by name, and where it is."""

from collections.abc import Mapping
from typing import Any, Protocol

from achse.iec.types import IecType
from achse.plc.lowering.project import LoweredProject
from achse.st.typed.project import Routine

__all__ = ["Linker", "Probe"]


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

    def __init__(self, project: LoweredProject) -> None:
        self.project = project
        self.probe: Probe | None = None
        """Of a debug build: what code says before each statement."""
        self.constants: dict[str, Any] = {}
        self._names: dict[str, str] = {}
        self._constant_names: dict[Any, str] = {}

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
