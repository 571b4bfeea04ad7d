"""Words of a line: what each is, and which are refused."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import Registers
from achse.gcode.text.blocks import AtCall, HashCall, RotationCall, parse_block
from achse.gcode.text.formula import Arithmetical


@pytest.mark.parametrize(
    ("line", "names", "values", "functions", "number"),
    [
        ("N10 G01 X10.5 Y-3 F600", ["G01"], {"X": 10.5, "Y": -3.0, "F": 600.0}, [], 10),
        ("n10g1x.5y+3.m8".upper(), ["G01"], {"X": 0.5, "Y": 3.0}, [8], 10),
        ("G00 X Y20 Z", ["G00"], {"X": None, "Y": 20.0, "Z": None}, [], 0),
        ("N5 (RAPID) G0 (HERE) X1", ["G00"], {"X": 1.0}, [], 5),
        ("CDON CFIN DELDTG G60", ["CDON", "CFIN", "DELDTG", "G60"], {}, [], 0),
        ("MIRROR X Y", ["MIRROR"], {"X": None, "Y": None}, [], 0),
        ("ROT X10 Z-20", ["ROT"], {"X": 10.0, "Z": -20.0}, [], 0),
        ("G1 X=10 Q1=5 Q5=-2.5", ["G01"], {"X": 10.0, "Q1": 5.0, "Q5": -2.5}, [], 0),
        ("DYNOVR=0.5", ["DYNOVR"], {"DYNOVR": 0.5}, [], 0),
        ("G1 X10 ANG=30", ["G01", "ANG"], {"X": 10.0, "ANG": 30.0}, [], 0),
        ("L100 P3", [], {"L": 100.0, "P": 3.0}, [], 0),
        ("S1000 T5 H-7 D2 M3 M8", [], {"S": 1000.0, "T": 5.0, "H": -7.0, "D": 2.0}, [3, 8], 0),
        ("% A NAME $&", [], {}, [], 0),
        ("", [], {}, [], 0),
        ("(NOT CLOSED", [], {}, [], 0),
    ],
)
def test_words_of_a_line(
    line: str,
    names: list[str],
    values: dict[str, float | None],
    functions: list[int],
    number: int,
) -> None:
    block = parse_block(line)
    assert [word.name for word in block.words] == names
    assert block.values == values
    assert block.functions == functions
    assert block.number == number


def test_skip_marks() -> None:
    assert parse_block("/ N10 X1").skip == 0
    assert parse_block("/15 N10 X1").skip == 15
    assert parse_block("N10 X1").skip == -1


def test_assignments_and_values_by_r_parameters() -> None:
    registers = Registers()
    registers[2] = 4.0
    block = parse_block("N1 R1=R2+3 R5=2.5 X=R2*2 YR2")
    assert [(n, formula.evaluate(registers)) for n, formula in block.assignments] == [
        (1, 7.0),
        (5, 2.5),
    ]
    results = {
        name: value.evaluate(registers)
        for name, value in block.values.items()
        if isinstance(value, Arithmetical)
    }
    assert results == {"X": 8.0, "Y": 4.0}


def test_at_commands_keep_their_signs() -> None:
    call = parse_block("N5 @121 R1 K9 K-10").call
    assert isinstance(call, AtCall)
    assert call.row is not None
    assert call.row.number == 121
    assert [(each.letter, each.value, each.sign) for each in call.operands] == [
        ("R", 1.0, ""),
        ("K", 9.0, ""),
        ("K", -10.0, "-"),
    ]
    more = parse_block("K13 K400 K14 K500").call
    assert isinstance(more, AtCall)
    assert more.row is None
    assert len(more.operands) == 4


def test_hash_commands() -> None:
    call = parse_block("#SET PARAMVERTEXSMOOTHING(2; 1; R5)#").call
    assert isinstance(call, HashCall)
    assert (call.verb, call.name, len(call.arguments)) == ("SET", "PARAMVERTEXSMOOTHING", 3)
    text = '#MSG(ITP; LOG; "Change the Tool")#'
    message = parse_block(text.upper(), text).call
    assert isinstance(message, HashCall)
    assert message.text == "Change the Tool"
    turn = parse_block("CALCINVROT[R1; R2; R3]").call
    assert turn == RotationCall(True, (1, 2, 3))


@pytest.mark.parametrize(
    ("line", "code", "word"),
    [
        ("G33", NcError.PROGRAM_SYNTAX_RUNNING, "G33"),
        ("G200", NcError.G_FUNCTION_INDEX, "G200"),
        ("M160", NcError.M_FUNCTION_INDEX, "M160"),
        ("G1 X1 X2", NcError.PROGRAM_SYNTAX_RUNNING, "X"),
        ("G1 FOO", NcError.PROGRAM_SYNTAX_RUNNING, "FOO"),
        ("X1.2.3", NcError.PROGRAM_SYNTAX_RUNNING, "."),
        ("X10 $", NcError.PROGRAM_SYNTAX_RUNNING, "$"),
        ("N10 N20", NcError.PROGRAM_SYNTAX_RUNNING, "N20"),
        ("X1 N20", NcError.PROGRAM_SYNTAX_RUNNING, "N20"),
        ("N99999999999", NcError.PROGRAM_SYNTAX_RUNNING, "N99999999999"),
        ("R1", NcError.PROGRAM_SYNTAX_RUNNING, "R1"),
        ("R=5", NcError.PROGRAM_SYNTAX_RUNNING, "R"),
        ("Q1", NcError.PROGRAM_SYNTAX_RUNNING, "Q1"),
        ("Q9=1", NcError.PROGRAM_SYNTAX_RUNNING, "Q9"),
        ("@999", NcError.PROGRAM_SYNTAX_RUNNING, "@999"),
        ("@", NcError.PROGRAM_SYNTAX_RUNNING, "@"),
        ("@121 R+1 K2 K3", NcError.PROGRAM_SYNTAX_RUNNING, "R+1"),
        ("#SET FOO", NcError.PROGRAM_SYNTAX_RUNNING, "#SET FOO"),
        ("#SET A(1;2 3)#", NcError.PROGRAM_SYNTAX_RUNNING, "3"),
        ("X1 /2", NcError.PROGRAM_SYNTAX_RUNNING, "/2"),
        ("/16 X1", NcError.PROGRAM_SYNTAX_RUNNING, "/16"),
        ("F", NcError.PROGRAM_SYNTAX_RUNNING, "F"),
        ("CDON=1", NcError.PROGRAM_SYNTAX_RUNNING, "CDON"),
        ("ANG30", NcError.PROGRAM_SYNTAX_RUNNING, "ANG"),
        ("@714 @716", NcError.PROGRAM_SYNTAX_RUNNING, "@716"),
        ("X" + "9" * 400, NcError.PROGRAM_SYNTAX_RUNNING, "X" + "9" * 19),
    ],
)
def test_wrong_words_are_refused_by_name(line: str, code: NcError, word: str) -> None:
    with pytest.raises(WordRefused) as refused:
        parse_block(line)
    assert (refused.value.code, refused.value.word) == (code, word)


@given(st.text(st.characters(max_codepoint=255, exclude_characters="\n"), max_size=60))
def test_hostile_lines_give_a_block_or_one_error(line: str) -> None:
    with suppress(WordRefused):
        parse_block(line.encode("latin-1").upper().decode("latin-1"), line)
