"""ProgramFault: where a part program failed, and where a retry or skip goes on."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum

from achse.codes import NcError
from achse.gcode.canon import Origin
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter
from achse.gcode.vectors import PathPoint

_BLOCK_NUMBER = re.compile(r"[/\d\s]*N(\d{1,9})", re.IGNORECASE)


def named_block(origin: Origin) -> str:
    """Return file, line and N word of a block, for people: `part.nc:3 (N30)`."""
    number = f" (N{origin.block})" if origin.block else ""
    return f"{origin.program or 'program'}:{origin.line}{number}"


def named_position(position: Iterable[float]) -> str:
    """Return X, Y, Z in mm, for people: `X10.000 Y0.000 Z0.000`."""
    return " ".join(f"{name}{value:.3f}" for name, value in zip("XYZ", position, strict=False))


class PlaceKind(IntEnum):
    """Kind of a `StoppedPlace`."""

    FAULT = 1
    """The program failed at this block."""
    FOUND = 2
    """A search found this block; the axes have to be at its begin."""


@dataclass(frozen=True, slots=True)
class StoppedPlace:
    """A block at which a program has failed or waits."""

    kind: PlaceKind
    origin: Origin
    position: PathPoint
    """X, Y, Z in mm: of a fault where the axes stopped, of a found block its begin."""


@dataclass(frozen=True, slots=True)
class ProgramFault:
    """A block that could not be run, or on which an axis or the group failed."""

    code: int
    origin: Origin
    unmade: Origin
    """First block whose move is not made: earlier than `origin` if cutter compensation delayed
    moves, for where they end depends on the block at fault."""
    registers: Sequence[float]
    """R parameters of the channel at the fault: a client has changed those that differ now."""
    text: str = ""
    """Sentence of the interpreter, if it found the fault."""
    stopped: PathPoint = (0.0, 0.0, 0.0)
    """X, Y, Z in mm where the axes came to rest."""

    def __str__(self) -> str:
        """Sentence for the log: place and reason."""
        row = NcError.of(self.code)
        reason = f"0x{self.code:04X}" + (f" {row.name}: {row.text}" if row else "")
        return self.text or f"{named_block(self.origin)}: error: {reason}"

    def resumes_at(self, *, skip: bool) -> int:
        """Return the counter of the block at which a retry, or a skip, begins to move."""
        if self.unmade.counter < self.origin.counter:
            return self.unmade.counter
        return self.origin.counter + int(skip)

    def registers_of_retry(self, begun: Iterable[float], now: Iterable[float]) -> list[float]:
        """Return R parameters as at the start, but for those changed since the fault."""
        pairs = zip(begun, self.registers, now, strict=True)
        return [start if same == value else value for start, same, value in pairs]


def refusal(
    refused: GcodeError, interpreter: Interpreter, registers: Sequence[float]
) -> ProgramFault:
    """Return the fault of a block that the interpreter refuses."""
    last, unmade = interpreter.origin, interpreter.unmade
    counter = interpreter.blocks
    if (last.program, last.line) != (refused.program, refused.line):  # it could not be read
        counter, unmade = counter + 1, interpreter.path.delayed_origin
    number = _BLOCK_NUMBER.match(refused.text)
    block = int(number[1]) if number else 0
    origin = Origin(refused.program, refused.line, refused.index, block, counter)
    return ProgramFault(refused.code.number, origin, unmade or origin, registers, str(refused))
