"""Emitted programs of this process: the next PLC with the same program is linked from them.

A restart of a station, and each test of a project, makes its PLC from the same sources again.
Lowering and writing all routines once more takes longer than the rest of that start.
"""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from types import CodeType
from typing import Any

_PROGRAMS = 64
_ROUTINES = 500
"""Most routines of a program that is kept: large ones would stay in memory a second time."""


@dataclass(frozen=True, slots=True)
class EmittedProgram:
    """The plain routines of a program before they are linked, by key."""

    codes: Mapping[str, CodeType]
    left_out: Mapping[str, str]
    """Routines that cannot run, and why."""
    constants: Mapping[str, Any]
    """Constants that the codes refer to, by name."""


class EmittedPrograms:
    """Programs by the digest of all that they follow from; those used last are kept."""

    def __init__(self) -> None:
        self._programs: OrderedDict[str, EmittedProgram] = OrderedDict()

    def get(self, digest: str) -> EmittedProgram | None:
        """Return the program of a digest; None if it is not kept."""
        program = self._programs.get(digest)
        if program is not None:
            self._programs.move_to_end(digest)
        return program

    def add(self, digest: str, program: EmittedProgram) -> None:
        """Keep a program unless it is large."""
        if len(program.codes) > _ROUTINES:
            return
        self._programs[digest] = program
        if len(self._programs) > _PROGRAMS:
            self._programs.popitem(last=False)


EMITTED = EmittedPrograms()
