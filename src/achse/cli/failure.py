"""Errors on stderr: a sentence, or with `--json` code, name and message."""

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

import typer

if TYPE_CHECKING:
    from achse.ams import AdsError

_in_json = False


def wants_json(words: Sequence[str]) -> bool:
    """Return True if a command line asks for JSON, which holds for errors in the command line
    itself too."""
    options = words[: words.index("--")] if "--" in words else words
    return "--json" in options


@contextmanager
def errors_in_json(wanted: bool) -> Iterator[None]:
    """Meanwhile errors are objects, or sentences."""
    global _in_json
    before, _in_json = _in_json, wanted
    try:
        yield
    finally:
        _in_json = before


def in_json() -> bool:
    """Return True if errors are printed as JSON objects."""
    return _in_json


def print_failure(message: str, *, name: str = "FAILED", code: int | None = None) -> None:
    """Print an error on stderr, as a sentence or an object; `code` is that of ADS, or None."""
    if _in_json:
        facts = {"code": code or None, "name": name, "message": message}
        message = dumped(facts, sys.stderr)
    print(message, file=sys.stderr)


def dumped(document: Any, stream: TextIO) -> str:
    """JSON on one line; what `stream` cannot write is escaped."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    text = json.dumps(document, ensure_ascii=not encoding.lower().startswith("utf"))
    try:
        text.encode(encoding)
    except UnicodeEncodeError:  # half a character, as in names of files that are not UTF-8
        return json.dumps(document)
    return text


def fail(
    message: str, exit_code: int = 1, *, name: str = "FAILED", code: int | None = None
) -> NoReturn:
    """Print an error, and end the command."""
    print_failure(message, name=name, code=code)
    raise typer.Exit(exit_code)


def fail_by(*refusals: "AdsError", hint: str = "") -> NoReturn:
    """Report what a target answered, or that it did not, and end; the first has code and name.

    `hint` says what helps; without one it is the remedy of the code, if all have the same code and
    none has a hint of its own.
    """
    from achse.codes.remedies import remedy_of

    first = refusals[0]
    text = "\n".join(map(str, refusals))
    codes = {getattr(each, "code", 0) for each in refusals}
    if not hint and len(codes) == 1 and not any(getattr(each, "hint", "") for each in refusals):
        hint = remedy_of(codes.pop())
    fail(
        f"{text.rstrip('.')}; {hint}" if hint else text,
        name=name_of(first),
        code=getattr(first, "code", None),
    )


def name_of(refusal: "AdsError") -> str:
    """`SYMBOL_NOT_FOUND` for a code of the tables, else the kind of error: `CONNECTION_LOST`."""
    from achse.codes import code_of

    code = getattr(refusal, "code", None)
    row = None if not code else code_of(code)
    if row is not None:
        return row.name
    kind = type(refusal).__name__
    return "".join(f"_{sign}" if sign.isupper() else sign for sign in kind).strip("_").upper()
