"""Rules of M functions: which of them wait for the PLC, which set a fast bit, what they clear.

Source: tcnci, parameterization of M functions; 002 §6.4.2 channel parameter 0x10 (mask and ten
cancelled M). The bits of the mask are not printed; ours are in the order of the columns.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag

from achse.codes import NcError
from achse.gcode.canon import Canonical, FastMReset, Handshake, MFunction, Origin
from achse.gcode.errors import WordRefused

PROGRAM_END = 2
SUBROUTINE_END = 17
PROGRAM_END_CLEAR = 30
"""M30: program end, and all fast M functions go out."""
MAX_CLEARED = 10
"""Fast M functions that one M function may clear."""


class MRuleBit(IntFlag):
    """Rule mask of channel parameter 0x10."""

    HANDSHAKE_BEFORE = 1 << 0
    HANDSHAKE_AFTER = 1 << 1
    FAST_BEFORE = 1 << 2
    FAST_AFTER = 1 << 3
    RESET_BEFORE = 1 << 4
    RESET_AFTER = 1 << 5


@dataclass(frozen=True, slots=True)
class MRule:
    """Rule of one M function."""

    handshake: Handshake = Handshake.NONE
    fast: Handshake = Handshake.NONE
    """Time at which its bit is set: never, before or after the move of its block."""
    auto_reset: bool = False
    """True if the bit is cleared at the end of the block."""
    clears: tuple[int, ...] = ()
    """Fast M functions, ten at most, that this one clears."""

    def __post_init__(self) -> None:
        if len(self.clears) > MAX_CLEARED:
            raise ValueError(f"expected {MAX_CLEARED} cleared M functions at most")

    @property
    def after_move(self) -> bool:
        """True if the function is placed behind the move of its block."""
        after = Handshake.AFTER_MOVE
        if self.handshake is not Handshake.NONE:
            return self.handshake is after
        return self.fast is after

    @property
    def mask(self) -> MRuleBit:
        """The rule as the mask that channel parameter 0x10 shows."""
        mask = MRuleBit(0)
        if self.handshake is not Handshake.NONE:
            before = self.handshake is Handshake.BEFORE_MOVE
            mask |= MRuleBit.HANDSHAKE_BEFORE if before else MRuleBit.HANDSHAKE_AFTER
        if self.fast is not Handshake.NONE:
            before = self.fast is Handshake.BEFORE_MOVE
            mask |= MRuleBit.FAST_BEFORE if before else MRuleBit.FAST_AFTER
            if self.auto_reset:
                mask |= MRuleBit.RESET_BEFORE if before else MRuleBit.RESET_AFTER
        return mask


NO_RULE = MRule()
"""An M function without parameters: the program skips it."""

MRules = Mapping[int, MRule]
"""By number 0..159."""


def placed(
    numbers: list[int], rules: MRules, origin: Origin
) -> tuple[list[Canonical], list[Canonical]]:
    """Return the M functions of a block: those before its move, and those behind it.

    Two handshakes in one block are refused. M17 has no rule: it only ends a subroutine.
    """
    before: list[Canonical] = []
    after: list[Canonical] = []
    handshake = 0
    resets: list[int] = []
    for number in numbers:
        if number == SUBROUTINE_END:
            continue
        rule = rules.get(number, NO_RULE)
        if rule.handshake is not Handshake.NONE:
            handshake += 1
            if handshake > 1:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING,
                    "only one M function with a handshake is allowed in a block",
                    f"M{number}",
                )
        fast = rule.fast is not Handshake.NONE
        command = MFunction(origin, number, rule.handshake, fast, rule.clears)
        (after if rule.after_move else before).append(command)
        if fast and rule.auto_reset:
            resets.append(number)
    if resets:
        after.append(FastMReset(origin, tuple(resets)))
    return before, after
