"""R parameters: 900 of the channel, 100 that all channels share, and the stack of @40..@43.

Source: tcnci, arithmetic parameters; 002 §6.4.2 (0x2300, offset 0x10000000 + n).
"""

from achse.codes import NcError
from achse.gcode.errors import WordRefused

OWN_REGISTERS = 900
"""R0..R899 belong to a channel."""
REGISTERS = 1000
"""R900..R999 exist once for all channels."""
STACK_DEPTH = 1000
"""Number of values that @40 and @41 may save; the manual states none, so each parameter fits
once."""


def shared_registers() -> list[float]:
    """R900..R999, to be handed to the registers of each channel."""
    return [0.0] * (REGISTERS - OWN_REGISTERS)


class Registers:
    """R0..R999 as doubles, reached by number; others are refused with 0x4140."""

    def __init__(self, shared: list[float] | None = None) -> None:
        self.own = [0.0] * OWN_REGISTERS
        self.shared = shared_registers() if shared is None else shared
        self.stack: list[float] = []

    def __getitem__(self, number: int) -> float:
        if 0 <= number < OWN_REGISTERS:
            return self.own[number]
        if OWN_REGISTERS <= number < REGISTERS:
            return self.shared[number - OWN_REGISTERS]
        raise self._outside(number)

    def __setitem__(self, number: int, value: float) -> None:
        if 0 <= number < OWN_REGISTERS:
            self.own[number] = value
        elif OWN_REGISTERS <= number < REGISTERS:
            self.shared[number - OWN_REGISTERS] = value
        else:
            raise self._outside(number)

    @staticmethod
    def _outside(number: int) -> WordRefused:
        return WordRefused(
            NcError.R_PARAMETER_INDEX, f"expected R0 to R{REGISTERS - 1}, got R{number}"
        )

    def pointed(self, number: int) -> int:
        """Return the number that R<number> holds: P<number> means that parameter."""
        value = self[number]
        if not 0.0 <= value < REGISTERS or value != int(value):
            raise WordRefused(
                NcError.R_PARAMETER_INDEX,
                f"P{number}: R{number} holds {value:g}, expected a number 0 to {REGISTERS - 1}",
            )
        return int(value)

    def save(self, numbers: list[int]) -> None:
        """Put the values of these parameters on the stack, in this order."""
        if len(self.stack) + len(numbers) > STACK_DEPTH:
            raise WordRefused(
                NcError.ARITHMETIC_STACK_OVERFLOW, f"the stack holds {STACK_DEPTH} values at most"
            )
        self.stack.extend(self[number] for number in numbers)

    def restore(self, numbers: list[int]) -> None:
        """Take values from the stack, the last first, into these parameters."""
        if len(numbers) > len(self.stack):
            raise WordRefused(
                NcError.ARITHMETIC_STACK_UNDERFLOW,
                f"{len(numbers)} values requested, the stack has {len(self.stack)}",
            )
        for number in numbers:
            self[number] = self.stack.pop()
