"""The lexer: a text as kinds, words and offsets of its tokens, with comments and pragmas aside.

One expression cuts the whole text, and a dictionary that fills itself says of each distinct word
what it is; both run in C. Literals are checked here, once per distinct word.

Source: IEC 61131-3 (2013) tables 1 to 9.
"""

import re
from collections.abc import Iterable, Mapping
from itertools import accumulate, compress

from achse.st.lexis.codes import Code
from achse.st.lexis.literals import malformed
from achse.st.lexis.pragmas import Conditions, ProjectDefines
from achse.st.lexis.words import BLOCK_WORDS, KEYWORDS, QUALIFIERS, SIGNS

Defines = Mapping[str, str] | Iterable[str] | ProjectDefines

NAME = "name"
INTEGER = "integer"
REAL = "real"
BOOLEAN = "boolean"
STRING = "string"
TYPED = "typed"
ADDRESS = "address"
PARTIAL = "partial"
END = "end"
LITERALS = frozenset((INTEGER, REAL, BOOLEAN, STRING, TYPED))

_BLANK = ""
BLANK = "blank"
COMMENT = _COMMENT = "comment"
PRAGMA = _PRAGMA = "pragma"
_OPEN = "open"
_FAULTY = "faulty"

_LONGEST_NAME = 255
"""Most characters of a name: tables have one byte for the length of an enumeration value's."""

_LONGEST_KEPT = 40
"""Most characters of a word whose kind is kept: longer words are texts and comments."""
_MOST_KEPT = 50_000
"""Most words whose kinds are kept."""

_CLOSED = (BLOCK_WORDS - {"TYPE"}) | {";", "STRUCT", "UNION", "END_STRUCT", "END_UNION"}
"""Tokens behind which something new begins."""

_BEHIND_NUMBERS = r"(?:THEN|DO|OF|TO|BY|AND|OR|XOR|MOD|AND_THEN|OR_ELSE|ELSE|ELSIF|END_REPEAT)\b"
"""Keywords that may follow a number without a blank: digits end at the first other sign, as in
`16#D013THEN`. In `16#FEND_IF` E is a digit, and what is left no keyword."""

_PATTERN = r"""
    \s++
    | [^\W\d]\w*+ (?: \# (?:
          '(?:[^'$\n]++|\$[^\n])*'
        | "(?:[^"$\n]++|\$[^\n])*"
        | (?: (?<=\bD\#) | (?<=\bLD\#) | (?<=\bDATE\#) | (?<=\bLDATE\#) ) \d++-\d++-\d++
        | (?: (?<=\bDT\#) | (?<=\bLDT\#) | (?<=_TIME\#) )
            \d++-\d++-\d++-\d++:\d++ (?: :\d++ (?:\.\d++)? )?
        | (?: (?<=\bTOD\#) | (?<=\bLTOD\#) | (?<=_DAY\#) ) \d++:\d++ (?: :\d++ (?:\.\d++)? )?
        | [+-]? (?: 2\#[01_]++ | 8\#[0-7_]++ | 10\#[\d_]++ | 16\#[\dA-F_]++ | [\d_]++ ) (?= WORDS )
        | [+-]? \d[\d_]*+ \# \w*+
        | [+-]? \d\w*+ (?:\.\d\w*+)* (?: (?<=\d[eE]) [+-]? \d++ )?
        | \w*+
      ) )?
    | //[^\n]*+
    | \(\* (?: [^(*]++ | \(++(?!\*) | \*++(?!\)) )* \*++\)
    | \(\*
    | /\* (?: [^/*]++ | /++(?!\*) | \*++(?!/) )* \*++/
    | /\*
    | :=|=>|<=|>=|<>|\.\.|\*\*|[-+*/=<>()\[\],;:.&^]
    | (?: 2\#[01_]++ | 8\#[0-7_]++ | 10\#[\d_]++ | 16\#[\dA-F_]++ ) (?= WORDS )
    | \d[\d_]*+ (?: \# \w*+ | (?:\.\d[\d_]*+)? (?:[eE][+-]?\d++)?
          (?: (?= WORDS ) | \w*+ ) )
    | '(?:[^'$\n]++|\$[^\n])*'
    | '(?:[^'$]++|\$.){0,1000}' (?= \s* [;,)] )
    | '(?:[^'$\n]++|\$[^\n])*
    | "(?:[^"$\n]++|\$[^\n])*"?
    | \{ (?: [^{}'"]++ | '(?:[^'$]++|\$.){0,200}' | "(?:[^"$]++|\$.){0,200}" ){0,200} \}
    | PRAGMA
    | %[^\W\d]++ (?: \* | \d++ (?:\.\d++)* )
    | .
    """.replace("WORDS", _BEHIND_NUMBERS)
_PRAGMAS = r"\{[^}]*+\}", r"\{[^}]*+\}?"
"""A pragma, and one that may be without an end, which is that of the text then."""
_MOST_OPEN = 50
"""Signs `{` without `}` at the end of a text, each of which is looked for an end."""
_TOKENS, _OUTSIDE = (
    tuple(re.compile(pattern.replace("PRAGMA", each), flags) for each in _PRAGMAS)
    for pattern, flags in (
        (_PATTERN, re.VERBOSE | re.IGNORECASE | re.DOTALL),
        (r"""'(?:[^'$\n]++|\$.)*'|"(?:[^"$\n]++|\$.)*"|//[^\n]*+|PRAGMA|\(\*|/\*""", re.DOTALL),
    )
)
"""Patterns by `_is_left_open`: the tokens, and text outside of nested comments."""
_OBJECT_ENDS = frozenset(
    ("END_FUNCTION", "END_FUNCTION_BLOCK", "END_PROGRAM", "END_TYPE", "END_INTERFACE")
)
_OBJECT_BOUNDS = _OBJECT_ENDS | {word.removeprefix("END_") for word in _OBJECT_ENDS}
_DEFINING = re.compile(r"\{\s*(?:UN)?DEFINE\b", re.IGNORECASE)
_ADDRESS = re.compile(r"%[IQM](?:\*|[XBWDL]?[0-9]+(?:\.[0-9]+)*)", re.IGNORECASE)
_PARTIAL = re.compile(r"%[XBWDL][0-9]{1,3}", re.IGNORECASE)
_DELIMITER = re.compile(r"\(\*|\*\)|/\*|\*/")
_CLOSING = {"(*": "*)", "/*": "*/"}


class _Kinds(dict[str, str]):
    """Kind of each word, for all texts of a process. `faults` maps faulty words to the reason,
    to the kind that the parser takes them for, and to the code."""

    def __init__(self) -> None:
        super().__init__(_KNOWN)
        self.faults: dict[str, tuple[str, str, Code]] = {}

    def __missing__(self, word: str) -> str:
        kind = self._classify(word)
        if len(word) <= _LONGEST_KEPT:
            self[word] = kind
        return kind

    def limit(self) -> None:
        """Begin again if too many words are kept."""
        if len(self) + len(self.faults) > _MOST_KEPT:
            self.clear()
            self.update(_KNOWN)
            self.faults.clear()

    def _classify(self, word: str) -> str:
        first = word[0]
        if first.isalpha() or first == "_":
            if "#" in word:
                return self._literal(TYPED, word)
            if len(word) > _LONGEST_NAME:
                reason = f"expected a name of up to {_LONGEST_NAME} characters, got {len(word)}"
                self.faults[word] = reason, NAME, Code.UNREADABLE_CHARACTER
                return _FAULTY
            return _KNOWN.get(word.upper(), NAME)
        if first.isspace():
            return _BLANK
        if first.isdecimal():
            return self._literal(INTEGER if word.isdecimal() or "#" in word else REAL, word)
        if first in "'\"":
            return self._literal(STRING, word)
        if first == "{" and word[-1] == "}":
            return _PRAGMA
        if first in "(/":
            return _COMMENT
        if first == "%" and _PARTIAL.fullmatch(word):
            return PARTIAL
        if first == "%" and _ADDRESS.fullmatch(word):
            return ADDRESS
        reason = {
            "{": "expected } at the end of this pragma",
            "%": "expected an address like %IX0.3, %MD4 or %Q*",
        }.get(first, f"expected Structured Text, got {word[:20]!r}")
        code = Code.OPEN_COMMENT if first == "{" else Code.UNREADABLE_CHARACTER
        self.faults[word] = reason, _BLANK, code
        return _FAULTY

    def _literal(self, kind: str, word: str) -> str:
        problem = malformed(word)
        if problem:
            self.faults[word] = problem, kind, Code.BAD_LITERAL
            return _FAULTY
        if kind is REAL and not any(sign in word for sign in ".eE"):
            return INTEGER
        return kind


_KNOWN: dict[str, str] = {
    **{sign: sign for sign in SIGNS},
    **{word: word for word in KEYWORDS},
    **{word.lower(): word for word in KEYWORDS},
    **dict.fromkeys(("TRUE", "FALSE", "true", "false"), BOOLEAN),
    **dict.fromkeys((" ", "\n", "\n\n", "\t", "    "), _BLANK),
    "&": "AND",
    "(*": _OPEN,
    "/*": _OPEN,
}
_KINDS = _Kinds()


class Tokens:
    """Kinds, words and offsets of the tokens, in step; the last is `END`.

    `before` holds the comments and pragmas that are before a token, `after` the comment that
    follows one in the same line; both by the token's offset.
    """

    __slots__ = ("after", "before", "faults", "kinds", "starts", "words")

    def __init__(self) -> None:
        self.kinds: list[str] = []
        self.words: list[str] = []
        self.starts: list[int] = []
        self.before: dict[int, list[str]] = {}
        self.after: dict[int, str] = {}
        self.faults: list[tuple[int, str, Code]] = []


def _is_left_open(text: str, start: int, end: int) -> bool:
    """Return True for so many pragmas without an end that it takes long to look for all of them."""
    last = max(text.rfind("}", start, end), start)
    return text.count("{", last, end) > _MOST_OPEN


def scan(text: str, start: int = 0, end: int | None = None, defines: Defines = ()) -> Tokens:
    """Return the tokens of a part of the text. What is none is listed in `faults` and left out."""
    end = len(text) if end is None else end
    _KINDS.limit()
    pattern = _TOKENS[_is_left_open(text, start, end)]
    words = pattern.findall(text, start, end)
    kinds = list(map(_KINDS.__getitem__, words))
    if _OPEN in kinds:
        flat = _flattened(text, start, end)
        words = pattern.findall(flat, start, end)
        kinds = list(map(_KINDS.__getitem__, words))
    starts = list(accumulate(map(len, words), initial=start))
    tokens = Tokens()
    if _FAULTY in kinds:
        for index, kind in enumerate(kinds):
            if kind is _FAULTY:
                reason, kinds[index], code = _KINDS.faults[words[index]]
                tokens.faults.append((starts[index], reason, code))
    asides = [index for index, kind in enumerate(kinds) if kind in (_COMMENT, _PRAGMA, _OPEN)]
    if asides:
        _set_aside(tokens, text, asides, kinds, words, starts, Conditions(defines))
    tokens.starts = list(compress(starts, kinds))
    tokens.words = list(compress(words, kinds))
    tokens.kinds = [kind for kind in kinds if kind]
    tokens.starts.append(end)
    tokens.words.append("")
    tokens.kinds.append(END)
    return tokens


def raw_words(text: str) -> list[tuple[str, str]] | None:
    """Return all of a text as kinds and words, blanks, comments and pragmas too; None if something
    in it is not Structured Text. The words one after the other are the text."""
    _KINDS.limit()
    pattern = _TOKENS[_is_left_open(text, 0, len(text))]
    words = pattern.findall(text)
    if _OPEN in map(_KINDS.__getitem__, words):
        words = pattern.findall(_flattened(text, 0, len(text)))
    pairs, at = [], 0
    for word in words:
        kind = _KINDS[word]
        if kind in (_FAULTY, _OPEN):
            return None
        pairs.append((BLANK if word.isspace() else kind, text[at : at + len(word)]))
        at += len(word)
    return pairs


def _set_aside(
    tokens: Tokens,
    text: str,
    asides: list[int],
    kinds: list[str],
    words: list[str],
    starts: list[int],
    conditions: Conditions,
) -> None:
    """Take comments, pragmas and what they exclude out of `kinds`, into `tokens`."""
    count = len(kinds)
    aside: list[tuple[int, str]] = []
    excluded = 0
    bounds = _object_bounds(words, kinds, asides)
    blanks = (0, 0)
    for index in asides:
        kind = kinds[index]
        while bounds and bounds[-1] < index:
            if kinds[bounds.pop()] in _OBJECT_ENDS:
                conditions.end_object()
            else:
                conditions.begin_object()
        at = starts[index]
        if kind is _OPEN:
            tokens.faults.append((at, "this comment has no end", Code.OPEN_COMMENT))
            kinds[index:] = [_BLANK] * (count - index)
            break
        kinds[index] = _BLANK
        if kind is _PRAGMA:
            counted = conditions.counts
            problem = conditions.take(words[index])
            if problem and counted:
                tokens.faults.append((at, problem, Code.BAD_CONDITION))
            if counted and not conditions.counts:
                excluded = index
            elif conditions.counts and not counted:
                kinds[excluded:index] = [_BLANK] * (index - excluded)
        if conditions.counts:
            aside.append((index, text[at : at + len(words[index])]))
        if kind is _PRAGMA and conditions.counts:
            blanks = _drop_end(index, kinds, words, blanks)
    if not conditions.counts:
        kinds[excluded:] = [_BLANK] * (count - excluded)
    if conditions.is_open:
        tokens.faults.append((starts[-1], "expected {END_IF}", Code.BAD_CONDITION))
    following, before, same = 0, -1, -1
    for index, word in aside:
        before, same = index, _token_before(index, kinds, words, before, same)
        if word[0] != "{" and same >= 0:
            tokens.after.setdefault(starts[same], word)
            continue
        following = max(following, index + 1)
        while following < count and not kinds[following]:
            following += 1
        if following < count:
            tokens.before.setdefault(starts[following], []).append(word)


def _object_bounds(words: list[str], kinds: list[str], asides: list[int]) -> list[int]:
    """Return the indices at which objects begin and end, the last first; empty if no define could
    outlive its object."""
    if not any(_DEFINING.match(words[index]) for index in asides if kinds[index] is _PRAGMA):
        return []
    return [index for index in range(len(kinds) - 1, -1, -1) if kinds[index] in _OBJECT_BOUNDS]


def _drop_end(
    index: int, kinds: list[str], words: list[str], blanks: tuple[int, int]
) -> tuple[int, int]:
    """Take out the `;` that some write behind a pragma, where no declaration or statement is open.

    It would part the pragma from what it belongs to. `blanks`: behind the first index there is
    nothing before the second; returns what is known now.
    """
    following = index + 1
    while following < len(kinds) and not kinds[following] and words[following].isspace():
        following += 1
    if following < len(kinds) and kinds[following] == ";":
        before = index - 1
        while before >= 0 and (not kinds[before] or words[before].upper() in QUALIFIERS):
            before = min(before, blanks[0] + 1) if before < blanks[1] else before
            before -= 1
        blanks = before, index
        if before < 0 or kinds[before] in _CLOSED:
            kinds[following] = _BLANK
    return blanks


def _token_before(index: int, kinds: list[str], words: list[str], known: int, same: int) -> int:
    """Return the token before a comment in the same line; -1 if there is none. Before the comment
    at `known` that is `same`."""
    index -= 1
    while index >= 0:
        if index == known and "\n" not in words[index]:
            return same
        if kinds[index]:
            return index
        if "\n" in words[index]:
            return -1
        index -= 1
    return -1


def _flattened(text: str, start: int, end: int) -> str:
    """Return the text with the signs of comments inside comments blanked out, at the same
    offsets."""
    parts: list[str] = []
    copied_to = position = start
    opening = ""
    depth = 0
    outside = _OUTSIDE[_is_left_open(text, start, end)]
    while delimiter := (_DELIMITER if depth else outside).search(text, position, end):
        sign = delimiter[0]
        position = delimiter.end()
        if depth == 0:
            if sign in _CLOSING:
                opening, depth = sign, 1
            continue
        if sign == opening:
            depth += 1
        elif sign == _CLOSING[opening]:
            depth -= 1
            if depth == 0:
                continue
        parts += [text[copied_to : delimiter.start()], "  "]
        copied_to = position
    return text[:start] + "".join(parts) + text[copied_to:]
