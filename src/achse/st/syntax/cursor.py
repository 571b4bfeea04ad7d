"""The parser's place in the tokens: what comes next, what was expected, where to go on."""

from collections.abc import Iterable

from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import END, NAME, Defines, Tokens, scan
from achse.st.lexis.pragmas import attribute_of
from achse.st.lexis.source import Diagnostic, Source
from achse.st.lexis.words import BLOCK_WORDS
from achse.st.syntax.tree import NO_NOTE, Name, Note

DEEPEST = 100
"""Deepest nesting of brackets, statements and types in each other."""
MOST_FAULTS = 100
"""Most faults that are reported for one file; the rest is noise."""
_NOTHING = "the end"
_SETTERS = frozenset(("S", "R", "REF"))


class Unexpected(Exception):
    """A syntax fault at an offset; caught where the parser can go on."""

    def __init__(self, at: int, message: str, code: Code) -> None:
        super().__init__(message)
        self.at = at
        self.message = message
        self.code = code


class Cursor:
    """Walks the tokens of one part of a source. `position` is the index of the next token."""

    def __init__(
        self, source: Source, start: int = 0, end: int | None = None, defines: Defines = ()
    ) -> None:
        self.source = source
        self.tokens: Tokens = scan(source.text, start, end, defines)
        self.kinds = self.tokens.kinds
        self.words = self.tokens.words
        self.starts = self.tokens.starts
        self.position = 0
        self.depth = 0
        self._faults = {at: (message, code) for at, message, code in reversed(self.tokens.faults)}

    @property
    def faults(self) -> list[Diagnostic]:
        """The faults so far, in order of their places."""
        faults = sorted(self._faults.items())[:MOST_FAULTS]
        return [self.source.fault(at, message, code) for at, (message, code) in faults]

    @property
    def fault_count(self) -> int:
        """Number of faults so far."""
        return len(self._faults)

    # what comes next -----------------------------------------------------------------------

    @property
    def at(self) -> int:
        """Offset of the next token."""
        return self.starts[self.position]

    def is_word(self, word: str, ahead: int = 0) -> bool:
        """Return True if the next token is a name that reads like this: PUBLIC, GET and the like
        are words only in certain places."""
        index = self.position + ahead
        return (
            index < len(self.kinds)
            and self.kinds[index] == NAME
            and self.words[index].upper() == word
        )

    def setter(self, ahead: int = 0) -> str | None:
        """`S=`, `R=` or `REF=` if one comes next: a name and a sign that touch each other."""
        position = self.position + ahead
        kinds = self.kinds
        if kinds[position] != NAME or kinds[position + 1] != "=":
            return None
        word = self.words[position].upper()
        touching = self.starts[position] + len(word) == self.starts[position + 1]
        return f"{word}=" if touching and word in _SETTERS else None

    def take(self, kind: str) -> bool:
        """Skip the next token if it is of that kind."""
        if self.kinds[self.position] == kind:
            self.position += 1
            return True
        return False

    def expect(self, kind: str, expected: str = "") -> int:
        """Skip a token of that kind and return its offset. Raises `Unexpected`."""
        position = self.position
        if self.kinds[position] != kind:
            raise self.unexpected(expected or f"'{kind}'")
        self.position = position + 1
        return self.starts[position]

    def name(self, expected: str = "a name") -> Name:
        """Skip a name. Raises `Unexpected`."""
        position = self.position
        if self.kinds[position] != NAME:
            raise self.unexpected(expected)
        self.position = position + 1
        return Name(self.words[position], self.starts[position])

    def path(self, expected: str = "a name") -> Name:
        """Skip names with dots between. Raises `Unexpected`."""
        first = self.name(expected)
        if self.kinds[self.position] != ".":
            return first
        words = [first.name]
        while self.take("."):
            words.append(self.name().name)
        return Name(".".join(words), first.at)

    def note(self, first: int, last: int) -> Note:
        """Return the comment and attributes of the declaration from token `first` to `last`."""
        before = self.tokens.before.get(self.starts[first])
        after = self.tokens.after.get(self.starts[last])
        if before is None and after is None:
            return NO_NOTE
        comments = []
        attributes = []
        for word in before or ():
            if word[0] != "{":
                comments.append(_comment_text(word))
            elif attribute := attribute_of(word):
                attributes.append(attribute)
        if after is not None:
            comments = [_comment_text(after)]
        return Note("\n".join(comments), tuple(attributes))

    # what was expected ---------------------------------------------------------------------

    def unexpected(self, expected: str) -> Unexpected:
        """Return the fault that says what was expected here, and what came."""
        position = self.position
        kind = self.kinds[position]
        came = "the end" if kind == END else f"'{self.words[position][:40]}'"
        at = self.starts[position]
        if position and self.kinds[position - 1]:
            end = self.starts[position - 1] + len(self.words[position - 1])
            # What is missing at the end of a line is missing there, not in the next line.
            if kind == END or (expected != _NOTHING and "\n" in self.source.text[end:at]):
                at = end
        return Unexpected(at, f"expected {expected}, got {came}", Code.UNEXPECTED_TOKEN)

    def report(self, fault: Unexpected) -> None:
        """Keep a fault; of several in one place, the first."""
        if len(self._faults) < 10 * MOST_FAULTS:
            self._faults.setdefault(fault.at, (fault.message, fault.code))

    def deeper(self) -> None:
        """Count one level of nesting. Raises `Unexpected` if there are too many."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise Unexpected(self.at, f"this nests deeper than {DEEPEST} levels", Code.TOO_DEEP)

    # where to go on ------------------------------------------------------------------------

    def expect_end(self, kind: str, expected: str = "") -> None:
        """Skip a token that ends something; report it missing where a line break is in
        for it, so that what follows is read as usual. Raises `Unexpected` otherwise."""
        if self.take(kind):
            return
        fault = self.unexpected(expected or f"'{kind}'")
        if fault.at == self.at:
            raise fault
        self.report(fault)

    def skip_to(self, stops: Iterable[str], start: int) -> None:
        """Go on after the next ';', or at the next word of `stops` or of a block; past at least
        one token since `start`."""
        stops = BLOCK_WORDS | frozenset(stops)
        kinds = self.kinds
        position = max(self.position, start)
        if position == start and kinds[position] != END:
            position += 1
        while (kind := kinds[position]) != END and kind not in stops:
            position += 1
            if kind == ";":
                break
        self.position = position


def _comment_text(comment: str) -> str:
    """Return a comment as clients see it: untrimmed, without its signs."""
    if comment.startswith("//"):
        return comment[2:].removeprefix("/").rstrip("\r\n")
    return comment[2:-2]
