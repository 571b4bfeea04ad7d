"""Words, offsets, comments and pragmas."""

from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.lexis import lexer
from achse.st.lexis.lexer import END, scan


def words(text: str) -> list[tuple[str, str]]:
    tokens = scan(text)
    assert tokens.faults == []
    return list(zip(tokens.kinds, tokens.words, strict=True))[:-1]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a:=b", [("name", "a"), (":=", ":="), ("name", "b")]),
        ("n" * 255, [("name", "n" * 255)]),
        ("If x tHEN", [("IF", "If"), ("name", "x"), ("THEN", "tHEN")]),
        ("1..10", [("integer", "1"), ("..", ".."), ("integer", "10")]),
        ("1.5..2", [("real", "1.5"), ("..", ".."), ("integer", "2")]),
        ("1E5 1.5e-3 2E+4", [("real", "1E5"), ("real", "1.5e-3"), ("real", "2E+4")]),
        ("16#1E-5", [("integer", "16#1E"), ("-", "-"), ("integer", "5")]),
        ("a.3.b", [("name", "a"), (".", "."), ("integer", "3"), (".", "."), ("name", "b")]),
        ("a.%X3", [("name", "a"), (".", "."), ("partial", "%X3")]),
        ("%IX0.3 %Q* %md12", [("address", "%IX0.3"), ("address", "%Q*"), ("address", "%md12")]),
        ("INT#-5 WORD#16#FF", [("typed", "INT#-5"), ("typed", "WORD#16#FF")]),
        ("REAL#1.5E-3-1", [("typed", "REAL#1.5E-3"), ("-", "-"), ("integer", "1")]),
        ("T#5s-T#3s", [("typed", "T#5s"), ("-", "-"), ("typed", "T#3s")]),
        ("LTIME#1d2h3m4.5s", [("typed", "LTIME#1d2h3m4.5s")]),
        ("D#2024-02-29-x", [("typed", "D#2024-02-29"), ("-", "-"), ("name", "x")]),
        ("DT#2024-02-29-12:00:00.5", [("typed", "DT#2024-02-29-12:00:00.5")]),
        ("DATE_AND_TIME#2024-2-9-1:2", [("typed", "DATE_AND_TIME#2024-2-9-1:2")]),
        ("TOD#12:34:56.789", [("typed", "TOD#12:34:56.789")]),
        ("STRING#'a$'b'", [("typed", "STRING#'a$'b'")]),
        ("E_X#Idle", [("typed", "E_X#Idle")]),
        ("'a$'b' \"x'y\"", [("string", "'a$'b'"), ("string", "\"x'y\"")]),
        ("'(* no comment *)'", [("string", "'(* no comment *)'")]),
        ("a<=b=>c<>d**e", [("name", "a"), ("<=", "<="), ("name", "b"), ("=>", "=>"),
                           ("name", "c"), ("<>", "<>"), ("name", "d"), ("**", "**"),
                           ("name", "e")]),
        ("x^.y", [("name", "x"), ("^", "^"), (".", "."), ("name", "y")]),
        ("a(*b*)c", [("name", "a"), ("name", "c")]),
        ("(* 1 (* 2 *) 3 *) a", [("name", "a")]),
        ("(* don't *) a (* 'x *)' *) b", None),
        ("/* 1 /* 2 */ */ a // b", [("name", "a")]),
        ("a // (* b\nc", [("name", "a"), ("name", "c")]),
        ("{x '}' y} a", [("name", "a")]),
        ("größe", [("name", "größe")]),
        ("TRUE false", [("boolean", "TRUE"), ("boolean", "false")]),
        ("&", [("AND", "&")]),
    ],
)  # fmt: skip
def test_words(text: str, expected: list[tuple[str, str]] | None) -> None:
    if expected is None:
        assert scan(text).faults
    else:
        assert words(text) == expected


def test_comments_are_kept_beside_their_tokens() -> None:
    tokens = scan("// one\n{attribute 'x'}\na; // two\nb (* three *) c\n// four\n")
    starts = dict(zip(tokens.words, tokens.starts, strict=True))
    assert tokens.before == {starts["a"]: ["// one", "{attribute 'x'}"]}
    assert tokens.after == {starts[";"]: "// two", starts["b"]: "(* three *)"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{attribute 'x'}; a : INT;", "a : INT ;"),
        ("VAR {attribute 'x'} ; a", "VAR a"),
        ("VAR_GLOBAL PERSISTENT\n{attribute 'x'};\na", "VAR_GLOBAL PERSISTENT a"),
        ("a; {attribute 'x'};\n{attribute 'y'};\nb", "a ; b"),
        ("STRUCT {attribute 'x'}; a", "STRUCT a"),
        ("a := 1 {info 'x'}; b", "a := 1 ; b"),
        ("a {info 'x'}\n; b", "a ; b"),
    ],
)
def test_an_end_sign_behind_a_pragma_belongs_to_it(text: str, words: str) -> None:
    tokens = scan(text)
    assert " ".join(tokens.words).strip() == words
    if "attribute" in text:
        (befores,) = tokens.before.values()
        assert len(befores) == text.count("attribute")


def test_comments_in_comments_are_kept_as_written() -> None:
    tokens = scan("(* a (* b *) c *) x")
    assert tokens.before[tokens.starts[0]] == ["(* a (* b *) c *)"]


def test_a_part_of_a_text() -> None:
    tokens = scan("abc (* x", 1, 3)
    assert (tokens.words, tokens.starts) == (["bc", ""], [1, 3])


def test_a_pragma_ends_at_the_next_brace() -> None:
    """As symbol files show of a source with `{attribute 'a'` and the brace in the next line."""
    text = "{attribute 'qualified only'\n{attribute 'strict'}\n{attribute 'b'} TYPE"
    tokens = scan(text)
    assert list(tokens.faults) == []
    assert tokens.words[0] == "TYPE"


@pytest.mark.parametrize(
    ("text", "at", "message"),
    [
        ("a (* b", 2, "this comment has no end"),
        ("a (* (* b *)", 2, "this comment has no end"),
        ("a /* b", 2, "this comment has no end"),
        ("'abc\n'", 0, "a string literal takes a closing '"),
        ("a {b", 2, "expected } at the end of this pragma"),
        ("a ~ b", 2, "expected Structured Text, got '~'"),
        ("a \\ b", 2, "expected Structured Text, got '\\\\'"),
        ("%X", 0, "expected an address"),
        ("5x", 0, "a number takes digits"),
        ("9" * 101, 0, "a number takes at most 100 digits"),
        ("名" * 256, 0, "expected a name of up to 255 characters, got 256"),
    ],
)
def test_what_is_no_word(text: str, at: int, message: str) -> None:
    (place, reported, _), *_ = scan(text).faults
    assert (place, reported.startswith(message)) == (at, True)


@given(st.text(alphabet="aB1 #'~{}%_.\n(*5x", max_size=40), st.integers(0, 3))
def test_kept_kinds_change_no_token(text: str, most: int) -> None:
    """Kinds of words are kept: of texts before, of none, and of so few that they are dropped."""
    with mock.patch.object(lexer, "_MOST_KEPT", len(lexer._KNOWN) + most):
        first, second = scan(text), scan(text)
    with mock.patch.object(lexer, "_KINDS", lexer._Kinds()):
        fresh = scan(text)
    for tokens in (first, second):
        assert (tokens.kinds, tokens.words, tokens.faults) == (
            fresh.kinds, fresh.words, fresh.faults,
        )  # fmt: skip


def test_long_words_are_not_kept() -> None:
    comment, name = f"(* {'x' * 100} *)", "n" * lexer._LONGEST_KEPT
    with mock.patch.object(lexer, "_KINDS", lexer._Kinds()) as kinds:
        scan(comment + name)
    assert (comment in kinds, name in kinds) == (False, True)


def test_conditions() -> None:
    text = "a {IF defined (X)} b {IF defined (Y)} c {ELSE} d {END_IF} {ELSE} e {END_IF} f"
    for defines, expected in (
        ((), "aef"), (("X",), "abdf"), (("x", "y"), "abcf"), (("Y",), "aef"),
    ):  # fmt: skip
        assert "".join(scan(text, defines=defines).words) == expected


@given(st.text(max_size=80))
def test_words_stand_where_they_say(text: str) -> None:
    tokens = scan(text)
    assert tokens.kinds[-1] == END
    assert tokens.starts == sorted(tokens.starts)
    if "(*" not in text and "/*" not in text:
        for word, start in zip(tokens.words, tokens.starts, strict=True):
            assert text.startswith(word, start)


def test_a_superscript_is_no_number() -> None:
    tokens = scan("A.¹ ²")
    assert [kind for kind in tokens.kinds if kind == "integer"] == []


@given(
    st.sampled_from([2, 8, 10, 16]),
    st.sampled_from(["", "WORD#", "INT#-", "ULINT#"]),
    st.data(),
    st.sampled_from(
        (
            "THEN",
            "Do",
            "of",
            "to",
            "BY",
            "AND",
            "or",
            "XOR",
            "mod",
            "AND_THEN",
            "OR_ELSE",
            "ELSE",
            "ELSIF",
            "END_REPEAT",
            "END_IF",
            "THENX",
            "OF_",
        )
    ),
)
def test_digits_end_before_a_keyword(base: int, type: str, data: st.DataObject, word: str) -> None:
    """As many signs as there are digits of the base belong to the number, then a keyword follows;
    anything else makes the whole a faulty number."""
    signs = "0123456789ABCDEF"[:base]
    digits = data.draw(st.text(signs, min_size=1, max_size=4), "digits")
    text = f"{type}{base}#{digits}{word}"
    end = len(text) - len(word)
    while text[end : end + 1].upper() in (*signs, "_"):
        end += 1
    known = {"THEN", "DO", "OF", "TO", "BY", "AND", "OR", "XOR", "MOD", "AND_THEN", "OR_ELSE"}
    known |= {"ELSE", "ELSIF", "END_REPEAT"}
    tokens = scan(f"{text} x")
    if text[end:].upper() in known:
        assert tokens.words == [text[:end], text[end:], "x", ""]
    else:
        assert tokens.words == [text, "x", ""]
        assert [at for at, *_ in tokens.faults] == [0]


@pytest.mark.parametrize(
    "number", ["16#D013", "16#fe", "2#1", "8#7", "WORD#16#D013", "INT#5", "12"]
)
def test_numbers_need_no_blank_before_then(number: str) -> None:
    tokens = scan(f"IF w = {number}THEN")
    assert tokens.faults == []
    assert tokens.words[3:] == [number, "THEN", ""]


def test_text_may_go_over_lines_if_it_ends_before_a_sign() -> None:
    assert words("s := 'a\n(*b';")[2] == ("string", "'a\n(*b'")
    tokens = scan("s := 'a;\nb := 'c';")
    assert len(tokens.faults) == 1
    assert "'c'" in tokens.words


@pytest.mark.parametrize("text", ["{", "{IF ", "{END_IF}", "{x};", "/**/", "{'$'}", "$'\n"])
def test_hostile_texts_take_time_by_their_length(text: str) -> None:
    tokens = scan(text * 5_000)  # much longer if each sign were compared with all others
    assert len(tokens.kinds) <= 5_001


def test_pragmas_without_an_end_are_faults_however_many() -> None:
    for count in (1, 30, 3_000):
        tokens = scan("a := 1; " + "{ b " * count)
        assert {message for _, message, _ in tokens.faults} == {
            "expected } at the end of this pragma"
        }
        assert tokens.words[:4] == ["a", ":=", "1", ";"]
