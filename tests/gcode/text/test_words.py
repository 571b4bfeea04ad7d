"""Rows of the dialect: complete, each once."""

from achse.gcode.text.words import AT_COMMANDS, G_WORDS, NAMED_WORDS, PATH_PARAMETERS, AtForm
from tests.gcode.programs import refused


def test_the_words_of_the_overview_are_there() -> None:
    """Source: tcnci, general command overview."""
    assert G_WORDS.keys() >= {
        *(0, 1, 2, 3, 4, 9, 17, 18, 19, 40, 41, 42, 53, 54, 55, 56, 57, 58, 59, 60),
        *(70, 71, 74, 90, 91, 700, 710),
    }
    assert NAMED_WORDS.keys() >= {
        *("ANG", "AROT", "CDOF", "CDON", "CFC", "CFIN", "CFTCP", "CIP", "CPCOF", "CPCON"),
        *("DELDTG", "DYNOVR", "FCONST", "FLIN", "MIRROR", "ROT"),
    }
    assert AT_COMMANDS.keys() >= {
        *(40, 41, 42, 43, 100, 111, 121, 122, 123, 124, 125, 126, 131, 132, 133, 134, 135, 136),
        *(141, 142, 143, 144, 145, 146, 151, 161, 200, 714, 716, 717),
    }


def test_words_of_other_dialects_are_refused() -> None:
    for number in (33, 43, *range(81, 90), *range(92, 97)):
        assert refused(f"G{number} X1").word == f"G{number}"


def test_rows_are_complete() -> None:
    for row in (*G_WORDS.values(), *NAMED_WORDS.values()):
        assert row.meaning
    assert len({form.value for form in AtForm}) == len(AtForm.__members__)
    assert {row.parameter for row in PATH_PARAMETERS.values()}
