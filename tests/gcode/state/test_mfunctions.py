"""Rules of M functions, and where they are placed around a move."""

import pytest

from achse.gcode.canon import FastMReset, Handshake, LineMove, MFunction, ProgramEnd
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.mfunctions import MRule, MRuleBit
from tests.gcode.programs import commands, refused

BEFORE, AFTER = Handshake.BEFORE_MOVE, Handshake.AFTER_MOVE
RULES = {
    40: MRule(BEFORE),
    41: MRule(AFTER),
    7: MRule(fast=BEFORE),
    8: MRule(fast=AFTER),
    9: MRule(clears=(7, 8)),
    10: MRule(fast=BEFORE, auto_reset=True),
    11: MRule(fast=AFTER, auto_reset=True),
    12: MRule(AFTER, fast=AFTER),
}


def order(block: str) -> list[str]:
    results = []
    for command in commands(f"F600\n{block}", MachineData(m_rules=RULES)):
        if isinstance(command, MFunction):
            results.append(f"M{command.number}")
        elif isinstance(command, FastMReset):
            results.append(f"reset {command.numbers}")
        elif isinstance(command, LineMove):
            results.append("move")
    return results


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        ("X1 M40", ["M40", "move"]),
        ("X1 M41", ["move", "M41"]),
        ("X1 M7 M8", ["M7", "move", "M8"]),
        ("X1 M9", ["M9", "move"]),
        ("X1 M10", ["M10", "move", "reset (10,)"]),
        ("X1 M11", ["move", "M11", "reset (11,)"]),
        ("X1 M12 M7", ["M7", "move", "M12"]),
        ("X1 M99", ["M99", "move"]),
        ("M40", ["M40"]),
    ],
)
def test_before_and_after_the_move(block: str, expected: list[str]) -> None:
    assert order(block) == expected


def test_commands_carry_their_rule() -> None:
    result = commands("M40\nM9\nM7\nM30", MachineData(m_rules=RULES))
    handshake, clearing, fast, _, end = result
    assert isinstance(handshake, MFunction)
    assert handshake.handshake is BEFORE
    assert isinstance(clearing, MFunction)
    assert clearing.clears == (7, 8)
    assert isinstance(fast, MFunction)
    assert fast.fast
    assert isinstance(end, ProgramEnd)
    assert end.clear_fast


def test_one_handshake_in_a_block() -> None:
    error = refused("X1 M40 M41", MachineData(m_rules=RULES))
    assert (error.word, error.column) == ("M41", 8)


def test_masks() -> None:
    assert MRule(BEFORE).mask == MRuleBit.HANDSHAKE_BEFORE
    assert MRule(AFTER, BEFORE, True).mask == (
        MRuleBit.HANDSHAKE_AFTER | MRuleBit.FAST_BEFORE | MRuleBit.RESET_BEFORE
    )
    assert MRule(fast=AFTER, auto_reset=True).mask == MRuleBit.FAST_AFTER | MRuleBit.RESET_AFTER
    with pytest.raises(ValueError, match="10"):
        MRule(clears=tuple(range(11)))
