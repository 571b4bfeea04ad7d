"""Text as PLC bytes: cp1252 or UTF-8 for STRING and table texts, UTF-16LE for WSTRING.

Source: recorded traffic of TwinCAT 3.1 targets.
"""

import codecs
import re
from typing import Literal, TypeAlias

Coding: TypeAlias = Literal["cp1252", "utf-8"]
"""Encoding of 8-bit text: cp1252, or UTF-8 (attribute `TcEncoding`, table flag 4)."""

# The five bytes cp1252 leaves open stand for the C1 controls of the same number, as on Windows,
# so that any byte of a STRING becomes text and comes back as the same byte.
_CP1252 = "".join(
    chr(code) if code in (0x81, 0x8D, 0x8F, 0x90, 0x9D) else bytes([code]).decode("cp1252")
    for code in range(256)
)
_CP1252_ENCODING = codecs.charmap_build(_CP1252)


def decode_text(data: bytes, coding: Coding = "cp1252") -> str:
    """Return the bytes as text; every byte has a meaning in cp1252, broken UTF-8 becomes U+FFFD."""
    if coding == "utf-8":
        return data.decode("utf-8", "replace")
    return codecs.charmap_decode(data, "strict", _CP1252)[0]


def encode_text(text: str, coding: Coding = "cp1252") -> bytes:
    """Return the text as bytes. Raises UnicodeEncodeError if a character has no code."""
    if coding == "utf-8":
        return text.encode("utf-8")
    return codecs.charmap_encode(text, "strict", _CP1252_ENCODING)[0]


_ESCAPED = re.compile(r"\\(?:x[0-9a-f]{2}|u[0-9a-f]{4}|U00(?:0[0-9a-f]|10)[0-9a-f]{4})")


def encode_name(name: str) -> bytes:
    """Return a name of a PLC program in cp1252: a sign without a code is `\\u540d`.

    Names of that kind have to differ in tables and to be found again.
    """
    return name.encode("ascii" if name.isascii() else "cp1252", "backslashreplace")


def plain_name(name: str) -> str:
    """Return a name of a table with the signs that `encode_name` has written in another way."""
    if "\\" not in name:
        return name
    return _ESCAPED.sub(lambda match: chr(int(match[0][2:], 16)), name)


def decode_wide(data: bytes) -> str:
    """UTF-16LE as text; lone surrogates become U+FFFD."""
    return data.decode("utf-16-le", "replace")


def encode_wide(text: str) -> bytes:
    """Return the text as UTF-16LE. Raises UnicodeEncodeError for a lone surrogate."""
    return text.encode("utf-16-le")
