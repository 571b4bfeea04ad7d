"""One line of a part program as a block: its words, sorted by what the interpreter does with them.

Most lines are letters with numbers and go a quick way: one expression checks the line, another
cuts it. All others are read word by word. Columns are found again when there is an error to show.
Source: tcnci, basic principles of NC programming.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isfinite

from achse.codes import NcError
from achse.gcode.canon import AUXILIARY_AXES
from achse.gcode.errors import WordRefused
from achse.gcode.text.formula import Arithmetical, parse_formula
from achse.gcode.text.words import ADDRESSES, AT_COMMANDS, G_WORDS, NAMED_WORDS, AtCommand, GWord

WordValue = float | Arithmetical | None
"""A number, a formula, or nothing (a bare letter)."""

MAX_BLOCK_NUMBER = 2**31 - 1
MAX_DIGITS = 300
"""Longer numbers may be out of the range of a double."""
M_FUNCTIONS = 160
"""M0..M159. Source: tcnci, available M functions."""
G_FUNCTIONS = 160
MAX_ARGUMENTS = 10
"""Of a command in # #; none has more than four."""
SKIP_LEVELS = 16
"""/0../15: bits of the skip mask."""


@dataclass(frozen=True, slots=True)
class AtOperand:
    """K, R or P of an @ command; `sign` is "", "+" or "-" as written behind K."""

    letter: str
    value: float
    sign: str = ""


@dataclass(frozen=True, slots=True)
class AtCall:
    """`@121 R1 K9 K-10`; without a row it goes on with the cases of the line before."""

    row: AtCommand | None
    operands: tuple[AtOperand, ...]


@dataclass(frozen=True, slots=True)
class HashCall:
    """`#set paramX(1;R2)#`: verb, name and arguments."""

    verb: str
    name: str
    arguments: tuple[Arithmetical, ...]
    text: str = ""
    """Of `#MSG(…)#`."""


@dataclass(frozen=True, slots=True)
class RotationCall:
    """`CalcRot(R1;R2;R3)`: turn a point in R parameters by the rotation, or back."""

    inverse: bool
    registers: tuple[int, int, int]


@dataclass(slots=True)
class ProgramBlock:
    """The words of one line."""

    number: int = 0
    skip: int = -1
    """Bit of the skip mask, -1 if the block always counts."""
    words: list[GWord] = field(default_factory=list)
    values: dict[str, WordValue] = field(default_factory=dict)
    """By address: X, Y, Z, Q1..Q5, I, J, K, B, U, F, S, T, H, D, P, L, and DYNOVR, ANG."""
    functions: list[int] = field(default_factory=list)
    """M functions in their order."""
    assignments: list[tuple[int, Arithmetical]] = field(default_factory=list)
    call: AtCall | HashCall | RotationCall | None = None
    bare: bool = False
    """True with only numbers for X, Y, Z, as in most lines of long programs."""

    def __bool__(self) -> bool:
        """Return True if the block has anything to execute."""
        return bool(self.words or self.values or self.functions or self.assignments or self.call)


_PLAIN = re.compile(r"\s*+(?:[A-Z]\s*+(?:[-+]?(?:\d++(?:\.\d*+)?|\.\d++)\s*+)?)*")
_CUT = re.compile(r"([A-Z])\s*+([-+]?[\d.]*+)")
_COMMENT = re.compile(r"\([^()]*+\)?")
_G_CACHE: dict[str, GWord] = {}
_AXES = frozenset("XYZ")


def parse_block(line: str, original: str = "") -> ProgramBlock:
    """Return the block of one line in upper case; `original` holds messages as they were written.

    Raises `WordRefused` with the word; its place in the line is `column_of(line, word)`.
    """
    if "(" in line and "#" not in line and "=" not in line and "CALC" not in line:
        line = _COMMENT.sub(lambda comment: " " * len(comment[0]), line)
    if _PLAIN.fullmatch(line):
        block = _plain_block(line)
        if block is not None:
            return block
    return _WordByWord(line, original or line).block


def _plain_block(line: str) -> ProgramBlock | None:
    """Return the block of letters with numbers; None if a word needs a closer look."""
    block = ProgramBlock()
    values = block.values
    for letter, number in _CUT.findall(line):
        if letter == "G":
            row = _G_CACHE.get(number)
            if row is None:
                return None
            block.words.append(row)
        elif letter == "N":
            if values or block.words or block.number or not number.isdecimal():
                return None
            block.number = int(number[:12])
            if block.number > MAX_BLOCK_NUMBER:
                return None
        elif letter == "M":
            if not number.isdecimal() or (value := int(number[:9])) >= M_FUNCTIONS:
                return None
            block.functions.append(value)
        elif letter in ADDRESSES and letter not in values:
            if number:
                if len(number) > MAX_DIGITS:
                    return None
                values[letter] = float(number)
            elif letter in _AXES:
                values[letter] = None
            else:
                return None
        else:
            return None
    if not block.words:
        if "K" in values and values.keys() <= {"K", "P"}:
            return None
        block.bare = values.keys() <= _AXES and not block.functions and None not in values.values()
    return block


def _as_meant(text: str) -> str:
    """Return a message of a file in UTF-8; others are Latin-1."""
    try:
        return text.encode("latin-1").decode("utf-8")
    except UnicodeError:
        return text


_BLANKS = re.compile(r"[\s;]*")
_NAME = re.compile(
    "(" + "|".join(sorted(NAMED_WORDS, key=len, reverse=True)) + r")(?![A-Z])\s*(=)?\s*"
)
_CALC = re.compile(r"CALC(INV)?ROT\s*[(\[]\s*R(\d{1,9})\s*;\s*R(\d{1,9})\s*;\s*R(\d{1,9})\s*[)\]]")
_AT = re.compile(r"@\s*(\d{1,6})")
_OPERAND = re.compile(r"\s*([KRP])\s*([-+]?)(\d{1,12}(?:\.\d*)?|\.\d+)")
_HASH = re.compile(r"#\s*(SET|GET|SKIP|MSG)\s*([A-Z0-9]*)\s*\(", re.IGNORECASE)
_ASSIGNED = re.compile(r"([A-Z]\d*)\s*=\s*")
_REGISTER = re.compile(r"([A-Z])(?=R\d)")
_NUMBERED = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))?")
_SEPARATOR = re.compile(r"\s*([;,)])")
_SKIP = re.compile(r"/\s*(\d*)")


class _WordByWord:
    """Reads a line from left to right."""

    def __init__(self, line: str, original: str) -> None:
        self.line = line
        self.original = original
        self.at = 0
        self.block = ProgramBlock()
        if line.lstrip().startswith("%"):
            return
        for word in self._words():
            self._word(word)

    def _words(self) -> Iterator[str]:
        """Begin of each word, until the line is done; blanks and comments are passed over."""
        line = self.line
        while True:
            blank = _BLANKS.match(line, self.at)
            assert blank is not None
            self.at = blank.end()
            if self.at >= len(line):
                return
            if line[self.at] == "(":
                comment = _COMMENT.match(line, self.at)
                assert comment is not None
                self.at = comment.end()
                continue
            before = self.at
            yield line[before]
            assert self.at > before

    def _refuse(
        self, message: str, word: str = "", code: NcError = NcError.PROGRAM_SYNTAX_RUNNING
    ) -> WordRefused:
        shown = word or self.line[self.at : self.at + 24].split(" ")[0]
        return WordRefused(code, message, shown)

    def _word(self, first: str) -> None:
        line, at = self.line, self.at
        if first == "/":
            self._skip()
        elif first == "@":
            self._at_call()
        elif first == "#":
            self._hash_call()
        elif match := _CALC.match(line, at):
            self.at = match.end()
            first_number, second, third = (int(match[each]) for each in (2, 3, 4))
            self._call(RotationCall(bool(match[1]), (first_number, second, third)), match[0])
        elif match := _NAME.match(line, at):
            self._named(match)
        elif match := _ASSIGNED.match(line, at):
            self.at = match.end()
            value = self._formula(match[0].strip())
            if match[1][0] == "R":
                if not match[1][1:]:
                    raise self._refuse("expected R0 to R999 before =", "R")
                self.block.assignments.append((int(match[1][1:10]), value))
            else:
                self._address(match[1], value)
        elif match := _REGISTER.match(line, at):
            self.at = match.end()
            self._address(match[1], self._formula(match[1]))
        elif match := _NUMBERED.match(line, at):
            self._numbered(match)
        else:
            raise self._refuse(f"{first!r} begins no word of this dialect", first)

    def _formula(self, word: str) -> Arithmetical:
        try:
            value, self.at = parse_formula(self.line, self.at)
        except WordRefused as refused:
            refused.word = refused.word or word
            raise
        return value

    def _skip(self) -> None:
        match = _SKIP.match(self.line, self.at)
        assert match is not None
        if self.block or self.block.skip >= 0:
            raise self._refuse("a skip mark is at the beginning of a block", match[0])
        level = int(match[1][:9] or "0")
        if level >= SKIP_LEVELS:
            raise self._refuse(f"expected /0 to /{SKIP_LEVELS - 1}", match[0])
        self.block.skip = level
        self.at = match.end()

    def _call(self, call: AtCall | HashCall | RotationCall, word: str) -> None:
        if self.block.call is not None:
            raise self._refuse("only one command of this kind is allowed in a block", word)
        self.block.call = call

    def _operands(self) -> tuple[AtOperand, ...]:
        operands = []
        while match := _OPERAND.match(self.line, self.at):
            if match[1] == "K":
                operands.append(AtOperand("K", float(match[2] + match[3]), match[2]))
            elif match[2] or not match[3].isdecimal():
                raise self._refuse(f"expected {match[1]} with a whole number", match[0].strip())
            else:
                operands.append(AtOperand(match[1], float(match[3])))
            self.at = match.end()
        return tuple(operands)

    def _at_call(self) -> None:
        match = _AT.match(self.line, self.at)
        if match is None:
            raise self._refuse("expected @ with the number of a command", "@")
        row = AT_COMMANDS.get(int(match[1]))
        if row is None:
            raise self._refuse("this @ command is unknown", match[0])
        self.at = match.end()
        self._call(AtCall(row, self._operands()), match[0])

    def _hash_call(self) -> None:
        begin = self.at
        end = self.line.find("#", begin + 1)
        match = _HASH.match(self.line, begin)
        if end < 0 or match is None or not self.line[begin + 1 : end].rstrip().endswith(")"):
            raise self._refuse(
                "expected #set …(…)#, #get …(…)#, #skip …(…)# or #MSG(…)#",
                self.line[begin : begin + 20],
            )
        last = self.line.rindex(")", begin, end)
        verb, name = match[1].upper(), match[2]
        if verb == "MSG":
            text = self.original[match.end() : last]
            parts = [part.strip() for part in text.split(";")]
            self._call(HashCall(verb, "", (), _as_meant(parts[-1].strip("\"' "))), "#")
            self.at = end + 1
            return
        arguments = []
        self.at = match.end()
        while self.at < last:
            arguments.append(self._formula(name))
            separator = _SEPARATOR.match(self.line, self.at)
            if separator is None or len(arguments) > MAX_ARGUMENTS:
                rest = self.line[self.at : min(last, self.at + 12)].strip()
                raise self._refuse(f"expected ; or ) in the arguments of {name}", rest)
            self.at = separator.end()
            if separator[1] == ")":
                break
        self._call(HashCall(verb, name, tuple(arguments)), "#")
        self.at = end + 1

    def _named(self, match: re.Match[str]) -> None:
        row = NAMED_WORDS[match[1]]
        self.at = match.end()
        self.block.words.append(row)
        if match[1] in ("ANG", "DYNOVR"):
            if not match[2]:
                raise self._refuse(f"expected {match[1]}=value", match[1])
            self._address(match[1], self._formula(match[1]))
        elif match[2]:
            raise self._refuse(f"{match[1]} has no value", match[1])

    def _address(self, name: str, value: WordValue) -> None:
        known = name in ADDRESSES or name in ("ANG", "DYNOVR")
        if not known and name[0] == "Q":
            known = name[1:].isdecimal() and 1 <= int(name[1:][:3]) <= AUXILIARY_AXES
        if not known:
            raise self._refuse("this address is unknown here", name)
        if name in self.block.values:
            raise self._refuse(f"{name} is twice in this block", name)
        if isinstance(value, Arithmetical):
            number = value.number
            value = value if number is None else number
        self.block.values[name] = value

    def _numbered(self, match: re.Match[str]) -> None:
        letter, number = match[1], match[2] or ""
        word = letter + number
        block = self.block
        if letter in "KRP" and self._is_case_line():
            block.call = AtCall(None, self._operands())
            return
        self.at = match.end()
        if letter == "N":
            if block or block.number or not number.isdecimal():
                raise self._refuse("expected N with a number at the beginning of a block", word)
            if len(number) > 12 or int(number) > MAX_BLOCK_NUMBER:
                raise self._refuse(f"expected a block number up to {MAX_BLOCK_NUMBER}", word)
            block.number = int(number)
        elif letter == "G":
            block.words.append(self._g_word(number, word))
        elif letter == "M":
            if not number.isdecimal() or len(number) > 9 or int(number) >= M_FUNCTIONS:
                raise self._refuse(
                    f"expected M0 to M{M_FUNCTIONS - 1}", word, NcError.M_FUNCTION_INDEX
                )
            block.functions.append(int(number))
        elif letter == "R" and number:
            raise self._refuse("expected = behind an R parameter", word)
        elif letter == "Q":
            raise self._refuse(f"expected Q1=… to Q{AUXILIARY_AXES}=…", word)
        elif letter not in ADDRESSES:
            raise self._refuse("this word is unknown", self._letters(match.start()))
        elif number:
            value = float(number)
            if not isfinite(value):
                raise self._refuse("the number is out of range", word[:20])
            self._address(letter, value)
        elif letter in _AXES:
            self._address(letter, None)
        else:
            raise self._refuse("expected a value", self._letters(match.start()))

    def _letters(self, at: int) -> str:
        """Return the unknown word as it is written: letters and what is directly behind them."""
        match = re.compile(r"[A-Z]+[-+\d.]*").match(self.line, at)
        return match[0] if match is not None else self.line[at]

    def _is_case_line(self) -> bool:
        block = self.block
        return not block and self.line[self.at] == "K" and bool(_OPERAND.match(self.line, self.at))

    def _g_word(self, number: str, word: str) -> GWord:
        row = G_WORDS.get(int(number)) if number.isdecimal() and len(number) < 9 else None
        if row is None:
            outside = number.isdecimal() and int(number[:9]) >= G_FUNCTIONS
            code = NcError.G_FUNCTION_INDEX if outside else NcError.PROGRAM_SYNTAX_RUNNING
            ours = _OTHER_DIALECTS.get(number.lstrip("0"), "")
            raise self._refuse(f"this G code is unknown{ours}", word, code)
        return row


_OTHER_DIALECTS = {"20": "; inches are G70", "21": "; millimetres are G71"}
"""Hints for G codes of other controls: the word of this control for the same function."""


def _fill_cache() -> None:
    for number, row in G_WORDS.items():
        _G_CACHE[str(number)] = row
        _G_CACHE[f"{number:02d}"] = row


_fill_cache()
