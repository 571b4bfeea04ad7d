"""Layout of texts: what changes, and that nothing else does."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.formatting.layout import formatted, indent_of
from achse.st.formatting.options import FormatOptions
from achse.st.lexis.lexer import BLANK, raw_words
from tests.rules.random_projects import Project
from tests.st.workspace.declared_edits import EditedProject
from tests.st.workspace.sample import FILES

MESSY = """FUNCTION_BLOCK FB
VAR
  a : INT;   // first
        {attribute 'hide'}
      b : ARRAY [0..1] OF INT := [1,
                                  2];
END_VAR
// start
IF a > 1 THEN
a := 2;
      // inner
   b[0] := a +
       b[1];
ELSIF a < 0 THEN
  CASE b[0] OF
    1, 2: a := 3;
    E_State.Idle:
    FOR a := 1 TO 3 DO
    b[1] := a;\t
    END_FOR
  ELSE
      ;
  END_CASE
END_IF
(* several
  lines\x20\x20
*)
"""
CLEAN = """FUNCTION_BLOCK FB
VAR
  a : INT;   // first
  {attribute 'hide'}
  b : ARRAY [0..1] OF INT := [1,
                              2];
END_VAR
// start
IF a > 1 THEN
  a := 2;
  // inner
  b[0] := a +
      b[1];
ELSIF a < 0 THEN
  CASE b[0] OF
    1, 2: a := 3;
    E_State.Idle:
      FOR a := 1 TO 3 DO
        b[1] := a;
      END_FOR
  ELSE
    ;
  END_CASE
END_IF
(* several
  lines\x20\x20
*)
"""


def _tokens(text: str) -> list[str] | None:
    words = raw_words(text)
    if words is None:
        return None
    return [w.rstrip() if w.startswith("//") else w for kind, w in words if kind != BLANK]


def _check(text: str, options: FormatOptions | None = None) -> None:
    result = formatted(text, options)
    assert _tokens(result) == _tokens(text)
    assert formatted(result, options) == result
    assert result.count("\n") == text.count("\n")


def test_lines_are_indented_by_the_words_around_them() -> None:
    assert formatted(MESSY) == CLEAN
    assert formatted(CLEAN) == CLEAN


def test_both_styles_of_units_stay() -> None:
    for inside in ("", "    "):
        text = (
            f"METHOD M : BOOL\n{inside}VAR\n{inside}    n : INT;\n{inside}END_VAR\n"
            f"{inside}n := 1;\n{inside}IF n = 1 THEN\n{inside}    n := 2;\n{inside}END_IF\n"
            "END_METHOD\n"
        )
        assert formatted(text) == text


@pytest.mark.parametrize("text", ["IF a THEN\n   b;\n", "  (* open\n", "END_IF\n  x := 1;\n"])
def test_texts_that_do_not_fit_keep_their_indentation(text: str) -> None:
    assert formatted(text) == text


def test_blanks_of_a_level_are_those_of_the_text_or_of_the_options() -> None:
    assert indent_of(["IF a THEN\n\tb;\n\tc;\nEND_IF"]) == 0
    assert indent_of(["a;"]) is None
    wide = formatted("IF a THEN\nb;\nEND_IF", FormatOptions(indent=8))
    assert wide == "IF a THEN\n        b;\nEND_IF"
    assert formatted("IF a THEN\n b;\nEND_IF", FormatOptions(indent=0)).split("\n")[1] == "\tb;"


def test_keywords_and_operators_change_if_options_say_so() -> None:
    text = "if a<=-1 then b:=a*2+ c; End_If // if\nx   := y;"
    assert formatted(text) == text
    upper = formatted(text, FormatOptions(keywords="upper"))
    assert upper == "IF a<=-1 THEN b:=a*2+ c; END_IF // if\nx   := y;"
    spaced = formatted(text, FormatOptions(operators=True))
    assert spaced == "if a <= -1 then b := a * 2 + c; End_If // if\nx   := y;"


@pytest.mark.parametrize(
    ("text", "expected"),
    [("a:=-\n1;", "a := -\n1;"), ("(\n*\n", "(\n*\n"), ("a+\nb", "a +\nb"), ("+ \n", "+\n")],
)
def test_sign_at_the_end_of_a_line_stays(text: str, expected: str) -> None:
    assert formatted(text, FormatOptions(operators=True)) == expected


def test_ends_of_lines_stay() -> None:
    assert formatted("IF a THEN\r\nb;  \r\nEND_IF\r\n") == "IF a THEN\r\n    b;\r\nEND_IF\r\n"


@given(
    st.integers(0, 1 << 32),
    st.sampled_from((None, 0, 2, 4)),
    st.sampled_from(("keep", "upper")),
    st.booleans(),
)
def test_words_of_random_projects_stay(
    seed: int, indent: int | None, keywords: str, operators: bool
) -> None:
    rng = Random(seed)
    text = Project(rng, False).text
    lines = [" " * rng.randrange(9) * (rng.random() < 0.3) + line for line in text.split("\n")]
    result = "\n".join(lines)
    _check(result, FormatOptions(indent, "keep", operators))
    other = formatted(result, FormatOptions(indent, keywords, operators))
    assert [w.upper() for w in _tokens(other) or ()] == [w.upper() for w in _tokens(result) or ()]


@given(st.text(alphabet=" \t\r\n;:=()[]{}*/+-'\"IFTHENcaseofEND_#1.^ä", max_size=60), st.booleans())
def test_any_text_keeps_its_words(text: str, operators: bool) -> None:
    options = FormatOptions(operators=operators)
    result = formatted(text, options)
    assert _tokens(result) == _tokens(text)
    assert formatted(result, options) == result


@given(st.randoms(use_true_random=False))
def test_words_of_damaged_sources_stay(rng: Random) -> None:
    text = EditedProject.damaged(rng.choice(list(FILES.values())), rng)
    _check(text)
