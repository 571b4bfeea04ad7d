"""The linker: what emitted code refers to by name, and where it is."""

import hashlib
from collections.abc import Mapping
from typing import Any, Protocol

from achse.iec.types import IecType
from achse.plc.code.source import identifier
from achse.plc.lowering.project import LoweredProject
from achse.st.typed.project import Routine


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
    """Names in emitted code: `routine_main` is a routine, `K_6f1e…` a constant.

    A name follows from the routine's key or from the constant's content, so that the routines of a
    library have the same text in all programs. Constants of equal names are numbered.
    """

    def __init__(self, project: LoweredProject) -> None:
        self.project = project
        self.probe: Probe | None = None
        """Probe of a debug build, called before each statement."""
        self.constants: dict[str, Any] = {}
        self._constant_names: dict[Any, str] = {}

    def name_of(self, key: str) -> str:
        """Return the Python name of a routine."""
        return f"routine_{identifier(key)}"

    def constant(self, value: Any) -> str:
        """Return the name of something that is not a literal of Python."""
        key = _identity(value)
        name = self._constant_names.get(key)
        if name is None:
            base = name = _constant_name(value)
            number = 1
            while name in self.constants:
                number += 1
                name = f"{base}_{number}"
            self._constant_names[key] = name
            self.constants[name] = value
        return name

    def adopt(self, constants: Mapping[str, Any]) -> None:
        """Begin with the constants of code that was emitted before."""
        self.constants.update(constants)
        self._constant_names.update({_identity(value): name for name, value in constants.items()})


def _identity(value: Any) -> Any:
    """Return the same for constants that can share a name."""
    return type(value), id(value) if isinstance(value, IecType) else repr(value)


def _constant_name(value: Any) -> str:
    """Return a name that follows from the content; types of equal names may share it."""
    content = value.name.lower() if isinstance(value, IecType) else repr(value)
    named = f"{type(value).__name__} {content}".encode("utf-8", "surrogatepass")
    return f"K_{hashlib.blake2b(named, digest_size=8).hexdigest()}"
