"""Standard functions and conversions of known values."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec import BYTE, DINT, INT, LREAL, REAL, TIME, UINT, WORD, IecType
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse_expression
from achse.st.syntax.tree import Expression
from achse.st.values.constants import Evaluator, Path
from achse.st.values.functions import called, is_standard
from achse.st.values.values import Constant, NotConstant, Value


def lookup(path: Path, at: int) -> Constant:
    raise Unexpected(at, "nothing", Code.NOT_A_VALUE)


def no_type(tree: Expression) -> IecType[int]:
    raise AssertionError(tree)


def evaluated(text: str) -> Constant:
    return Evaluator(lookup, no_type).value(parse_expression(text))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("TO_INT(2.5)", 3),
        ("TO_INT(-2.5)", -3),
        ("LREAL_TO_INT(1.4)", 1),
        ("TO_BYTE(300)", 44),
        ("TO_SINT(255)", -1),
        ("TO_BOOL(5)", True),
        ("BOOL_TO_INT(TRUE)", 1),
        ("TO_LREAL(3)", 3.0),
        ("TO_TIME(1500)", 1500),
        ("TO_TIME(4294967295)", 4294967295),
        ("TO_TOD(4294967295)", 4294967295),
        ("TIME_TO_DINT(T#2s)", 2000),
        ("TO_LTIME(T#1ms)", 1_000_000),
        ("ABS(-5)", 5),
        ("MIN(3, 1, 2)", 1),
        ("LIMIT(0, 11, 10)", 10),
        ("SEL(TRUE, 1, 2)", 2),
        ("TRUNC(-2.7)", -2),
        ("SQRT(9)", 3.0),
        ("EXPT(2, 10)", 1024.0),
        ("SHL(1, 4)", 16),
        ("SHR(16, 4)", 1),
        ("ABS(T#5ms)", 5),
        ("MAX(1, 2.5)", 2.5),
        ("MAX(3, 2.5)", 3.0),
        ("MAX(T#1s, T#2s)", 2000),
        ("MIN('b', 'a')", "a"),
        ("LIMIT(INT#1, INT#0, INT#10)", 1),
        ("SEL(0, 1, 2)", 1),
        ("SEL(TRUE, 'a', 'b')", "b"),
        ("MUX(2, 10, 20, 30)", 30),
        ("MOVE(5)", 5),
        ("TRUNC_INT(2.9)", 2),
        ("SHL(BYTE#16#81, 1)", 2),
        ("SHL(1, 20)", 1 << 20),
        ("SHR(WORD#16#8000, 15)", 1),
        ("SHL(INT#1, 15)", -32768),
        ("ROL(BYTE#16#81, 1)", 3),
        ("ROR(BYTE#16#81, 1)", 0xC0),
        ("LEN('four')", 4),
        ("CONCAT('a', CONCAT('b', 'c'))", "abc"),
        ("LEFT('SUSI', 3)", "SUS"),
        ("RIGHT('SUSI', 3)", "USI"),
        ("MID('SUSI', 2, 2)", "US"),
        ("INSERT('SUSI', 'XY', 2)", "SUXYSI"),
        ("DELETE('SUXYSI', 2, 3)", "SUSI"),
        ("REPLACE('SUXYSI', 'K', 2, 2)", "SKYSI"),
        ("FIND('abcdef', 'cd')", 3),
        ("FIND('abc', 'x')", 0),
        ('WCONCAT("a", "b")', "ab"),
        ('WLEN("abc")', 3),
        ("TO_STRING(5)", "5"),
        ("INT_TO_STRING(-302)", "-302"),
        ("BOOL_TO_STRING(TRUE)", "TRUE"),
        ("TO_STRING(1.5)", "1.5"),
        ("TO_STRING(REAL#0.1)", "0.1"),
        ("LREAL_TO_STRING(2)", "2"),
        ("TIME_TO_STRING(T#1500ms)", "T#1s500ms"),
        ("DATE_TO_STRING(D#2002-08-18)", "D#2002-08-18"),
        ("TO_STRING('text')", "text"),
        ("STRING_TO_INT('12')", 12),
        ("STRING_TO_INT(' -12 ')", -12),
        ("STRING_TO_INT('none')", 0),
        ("STRING_TO_LREAL('1.5')", 1.5),
        ("STRING_TO_BOOL('true')", True),
        ("STRING_TO_BOOL('yes')", False),
        ("STRING_TO_TIME('T#2s')", 2000),
        ("STRING_TO_TIME('2')", 0),
        ("DT_TO_DATE(DT#2020-01-02-03:04:05)", 1577923200),
        ("DT_TO_TOD(DT#2020-01-02-03:04:05)", 11_045_000),
        ("LTIME_TO_TIME(LTIME#1ms900us)", 1),
        ("ANY_TO_INT(1.5)", 2),
        ("DATE_AND_TIME_TO_UDINT(DT#1970-01-01-00:01)", 60),
    ],
)
def test_values(text: str, value: Value) -> None:
    result = evaluated(text).value
    assert (result, type(result)) == (value, type(value))


@pytest.mark.parametrize(
    ("text", "type"),
    [
        ("MAX(T#1s, T#2s)", TIME),
        ("SEL(TRUE, UINT#1, UINT#2)", UINT),
        ("SEL(TRUE, UINT#1, INT#2)", None),
        ("MAX(REAL#1.5, REAL#2)", REAL),
        ("MAX(REAL#1.5, LREAL#2)", LREAL),
        ("ABS(INT#-1)", INT),
        ("TRUNC(1.5)", DINT),
        ("LEN('a')", INT),
        ("SHL(WORD#1, 2)", WORD),
        ("TO_BYTE(1)", BYTE),
    ],
)
def test_results_have_the_type_of_what_they_are_made_of(
    text: str, type: IecType[object] | None
) -> None:
    assert evaluated(text).type is type


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("SQRT()", "SQRT takes another number of arguments, got 0"),
        ("LIMIT(1)", "LIMIT takes another number of arguments"),
        ("TO_INT(1, 2)", "TO_INT takes another number of arguments"),
        ("SEL(2, 1, 2)", "SEL takes a BOOL first, got 2"),
        ("MUX(3, 1, 2)", r"MUX takes 0\.\.1 first, got 3"),
        ("MAX(1, 'a')", "values of one kind, got 1, 'a'"),
        ("MAX(T#1s, LTIME#1s)", "values of one kind"),
        ("ABS('a')", "a number, got 'a'"),
        ("SQRT('a')", "a number, got 'a'"),
        ("SHL(1.5, 1)", "a whole number, got 1.5"),
        ("SHL(1, -1)", "a count of 0 or more, got -1"),
        ("LEN(5)", "texts and positions, got 5"),
        ("CONCAT('a', 5)", "texts and positions"),
        ("LEFT('a', 'b')", "texts and positions"),
        ("EXPT(10, 999)", "there is no such value"),
    ],
)
def test_what_is_no_argument(text: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        evaluated(text)


@pytest.mark.parametrize("text", ["TO_STRING(1.0E20)", "STRING_TO_INT('5 parts')"])
def test_where_targets_differ_nothing_is_made_up(text: str) -> None:
    with pytest.raises(NotConstant):
        evaluated(text)


def test_names() -> None:
    assert is_standard("MAX")
    assert is_standard("DINT_TO_LREAL")
    assert is_standard("TIME_OF_DAY_TO_STRING")
    assert not is_standard("SCALE_TO_INT")
    assert not is_standard("TO_ST_POINT")
    assert not is_standard("F_MAX")


def test_no_root_of_a_negative_number() -> None:
    value = evaluated("SQRT(-1)").value
    assert isinstance(value, float)
    assert math.isnan(value)


def test_a_text_is_cut_where_a_string_ends() -> None:
    result = called("CONCAT", [Constant("a" * 200), Constant("b" * 200)], 0)
    assert result.value == "a" * 200 + "b" * 55


@given(st.integers(-(1 << 15), (1 << 15) - 1))
def test_a_number_comes_back_from_its_text(number: int) -> None:
    text = called("INT_TO_STRING", [Constant(number, INT)], 0)
    assert called("STRING_TO_INT", [text], 0) == (number, INT)


@given(st.binary(min_size=2, max_size=2), st.integers(0, 100))
def test_rotating_there_and_back_changes_nothing(data: bytes, count: int) -> None:
    value = Constant(int.from_bytes(data, "little"), WORD)
    turned = called("ROL", [value, Constant(count)], 0)
    assert called("ROR", [turned, Constant(count)], 0) == value
