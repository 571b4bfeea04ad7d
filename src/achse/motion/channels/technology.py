"""Technology functions for the PLC: M functions with and without handshake, H, S and T.

Fast M functions are bits, set and cleared when the path gets there. One M function with a handshake
is shown at a time: its number with a request, until the PLC grants it.
"""

from collections.abc import Iterable
from enum import Enum

from achse.gcode.canon import Technology

M_FUNCTIONS = 160
FAST_WORDS = M_FUNCTIONS // 32


class HandshakeStep(Enum):
    """Step of the handshake of an M function."""

    NONE = "no M function is requested"
    BEFORE = "the PLC still grants the one before"
    REQUESTED = "the request is shown"


class TechnologyOutputs:
    """The part of the cyclic structure that programs fill."""

    def __init__(self) -> None:
        self.fast = [0] * FAST_WORDS
        """M0..M159, bit n % 32 of word n // 32."""
        self.number = 0
        """M function with a handshake."""
        self.request = 0
        self.auxiliary = 0
        """H."""
        self.spindle = 0
        """S, rpm."""
        self.tool = 0
        """T."""
        self.step = HandshakeStep.NONE

    def set_fast(self, number: int) -> None:
        """Set the bit of a fast M function."""
        self.fast[number // 32] |= 1 << number % 32

    def clear_fast(self, numbers: Iterable[int]) -> None:
        """Clear bits of fast M functions."""
        for number in numbers:
            self.fast[number // 32] &= ~(1 << number % 32)

    def is_fast(self, number: int) -> bool:
        """Return True if the bit is set."""
        return bool(self.fast[number // 32] >> number % 32 & 1)

    def show(self, word: Technology, value: float) -> None:
        """Show a value of H, S or T."""
        number = int(value)
        if word is Technology.AUXILIARY:
            self.auxiliary = max(-0x8000_0000, min(0x7FFF_FFFF, number))
        elif word is Technology.SPINDLE:
            self.spindle = number & 0xFFFF
        else:
            self.tool = number & 0xFFFF

    def handshake(self, number: int, granted: int) -> bool:
        """Advance a handshake by one cycle; True if it is over. `granted` comes from the PLC."""
        if self.step is HandshakeStep.NONE:
            self.step = HandshakeStep.BEFORE
        if self.step is HandshakeStep.BEFORE:
            if granted:
                return False
            self.number, self.request, self.step = number, 1, HandshakeStep.REQUESTED
            return False
        if not granted:
            return False
        self.request, self.step = 0, HandshakeStep.NONE
        return True

    def drop(self) -> None:
        """Take a request away, whatever came of it."""
        self.request, self.step = 0, HandshakeStep.NONE

    def clear(self) -> None:
        """Clear all fast M functions, H, S and T, as M30 and a reset do."""
        self.fast = [0] * FAST_WORDS
        self.auxiliary = self.spindle = self.tool = 0
