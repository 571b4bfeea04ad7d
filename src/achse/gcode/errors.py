"""Errors of a part program: place, word, documented code."""

from achse.codes import NcError


class WordRefused(Exception):
    """A word or value is not allowed. The interpreter adds the place and raises `GcodeError`."""

    def __init__(self, code: NcError, message: str, word: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.word = word


class GcodeError(Exception):
    """A block cannot be run: code, place and sentence.

    `index` is the text index of the block (channel state 0x10): the offset of its first byte.
    """

    def __init__(
        self,
        code: NcError,
        message: str,
        *,
        program: str = "",
        line: int = 0,
        column: int = 1,
        index: int = 0,
        word: str = "",
        text: str = "",
    ) -> None:
        self.code = code
        self.message = message
        self.program = program
        self.line = line
        self.column = column
        self.index = index
        self.word = word
        self.text = text
        super().__init__(str(self))

    def __str__(self) -> str:
        named = f"{self.word}: " if self.word else ""
        named, message = _printable(named), _printable(self.message)
        place = f"{self.program or 'program'}:{self.line}:{self.column}"
        return f"{place}: error: {named}{message} ({self.code.number:#06x} {self.code.name})"

    def caret(self) -> str:
        """Return the block with a mark under the word."""
        text = _printable(self.text.replace("\t", " "))
        return f"{text}\n{' ' * (self.column - 1)}^"


def _printable(text: str) -> str:
    """Other files than part programs bring no control characters to a terminal or log."""
    return "".join(each if each.isprintable() else "?" for each in text)
