"""Frames of the Debug Adapter Protocol: a head with the length, and JSON.

Source: Debug Adapter Protocol 1.6x, base protocol.
"""

import json
import re
from typing import Any

_LARGEST_HEAD = 4096
_LARGEST_BODY = 1 << 22
_END = b"\r\n\r\n"
_FIELD = re.compile(rb"([A-Za-z-]+):(.*)", re.DOTALL)


class DapFrameError(Exception):
    """Raised for bytes that are not a frame, so that the start of the next frame is unknown."""


def encode_frame(message: dict[str, Any]) -> bytes:
    """Return a message as sent."""
    body = json.dumps(message, ensure_ascii=False).encode("utf-8", "replace")
    return b"Content-Length: %d" % len(body) + _END + body


class FrameReader:
    """Takes bytes as they come, gives whole messages. Sans I/O."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._length: int | None = None

    def feed(self, data: bytes) -> list[Any]:
        """Return the JSON values of all frames that are whole now; None for a body that is not
        JSON.

        Raises `DapFrameError`.
        """
        self._data += data
        messages: list[Any] = []
        while True:
            if self._length is None:
                end = self._data.find(_END)
                if end < 0:
                    if len(self._data) > _LARGEST_HEAD:
                        raise DapFrameError(f"a head has at most {_LARGEST_HEAD} bytes")
                    return messages
                self._length = _length_of(bytes(self._data[:end]))
                del self._data[: end + len(_END)]
            if len(self._data) < self._length:
                return messages
            body = bytes(self._data[: self._length])
            del self._data[: self._length]
            self._length = None
            try:
                messages.append(json.loads(body))
            except (ValueError, RecursionError):
                messages.append(None)


def _length_of(head: bytes) -> int:
    """Nothing but fields: what a web page makes a browser send is refused at its first line."""
    length: int | None = None
    for line in head.split(b"\r\n"):
        field = _FIELD.fullmatch(line)
        if field is None:
            raise DapFrameError(f"a head has fields like Content-Length: 5, got {line[:40]!r}")
        if field[1].lower() != b"content-length":
            continue
        text = field[2].strip()
        if not text.isdigit() or len(text) > 9 or int(text) > _LARGEST_BODY:
            raise DapFrameError(f"Content-Length: 0 to {_LARGEST_BODY}, got {text[:20]!r}")
        length = int(text)
    if length is None:
        raise DapFrameError("a head without Content-Length")
    return length
