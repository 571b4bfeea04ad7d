"""Documents, TOML and JSON, as they come from files: whatever is in them, a value or a ValueError.

The parsers of Python's library give up with other errors where a document nests too deep, or a
number is too long. Files that a document names are checked by `check_file` before they are read.
"""

import errno
import json
import re
import tomllib
from pathlib import Path
from typing import Any

DEEPEST = 64
"""Tables within tables, lists within lists; what we read needs five."""

_LARGEST_FILE = 256 << 20
"""Size of a file that a document names, bytes."""

_LONG_KEY = re.compile(
    r"""(?:^|[{,\[])[ \t]*(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){64}""",
    re.MULTILINE,
)
"""A dotted key of more parts than that. The parser takes hours for 100,000 of them."""


def parse_toml(text: str) -> dict[str, Any]:
    """Return the document of a text. Raises ValueError."""
    if _LONG_KEY.search(text):
        raise _too_deep()
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise _too_deep() from None
    check_depth(document)
    return document


def parse_json(text: str | bytes) -> Any:
    """Return the document of a text. Raises ValueError."""
    try:
        document = json.loads(text)
    except RecursionError:
        raise _too_deep() from None
    check_depth(document)
    return document


def check_file(file: Path) -> None:
    """Raise OSError for a file that is not there, may never end (a pipe, a device) or is too large.

    A folder passes: its reader reports it.
    """
    size = file.stat().st_size
    if not (file.is_file() or file.is_dir()):
        raise OSError(errno.EINVAL, "not a regular file", str(file))
    if size > _LARGEST_FILE:
        raise OSError(errno.EFBIG, f"larger than {_LARGEST_FILE >> 20} MB", str(file))


def check_depth(document: object) -> None:
    """Raise ValueError for a document that nests too deep."""
    level = [document]
    for _ in range(DEEPEST + 1):
        below: list[object] = []
        for value in level:
            if isinstance(value, dict):
                below += value.values()
            elif isinstance(value, list):
                below += value
        if not below:
            return
        level = below
    raise _too_deep()


def _too_deep() -> ValueError:
    return ValueError(f"it nests deeper than {DEEPEST} levels")
