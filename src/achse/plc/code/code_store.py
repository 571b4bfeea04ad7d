"""Compiled routines in the user's cache, for processes to come.

Of a start with plain code, a sixth is the work of Python's compiler. A file has the routines of one
set of source files; a routine is known by its Python source, so that after an edit the others stay.
"""

import hashlib
import marshal
import sys
from collections.abc import Callable, Iterable
from importlib.util import MAGIC_NUMBER
from types import CodeType

from achse.native.backend.cache import ObjectCache

_DIGEST_SIZE = 20


class CodeStore:
    """Codes of the routines of some source files, by their Python sources."""

    def __init__(self, paths: Iterable[str]) -> None:
        python = MAGIC_NUMBER, sys.implementation.cache_tag, sys.flags.optimize
        content = repr((python, sorted(paths))).encode()
        digest = hashlib.blake2b(content, digest_size=_DIGEST_SIZE).hexdigest()
        self._file = ObjectCache("plain", digest)
        self._codes = _read(self._file.load())
        self._used: dict[bytes, CodeType] = {}

    def code(
        self,
        text: str,
        places: tuple[int, ...],
        make: Callable[[str, tuple[int, ...]], CodeType],
    ) -> CodeType:
        """Return the code of a Python source whose lines are at `places`; `make` compiles one that
        is not kept.
        """
        source = repr((text, places)).encode()
        key = hashlib.blake2b(source, digest_size=_DIGEST_SIZE).digest()
        cached = self._codes.get(key)
        self._used[key] = code = make(text, places) if cached is None else cached
        return code

    def save(self) -> None:
        """Keep the codes that were used, and no others."""
        if self._used.keys() != self._codes.keys():
            self._file.save(marshal.dumps(self._used))


def _read(content: bytes | None) -> dict[bytes, CodeType]:
    """Return the kept codes; none if they are of another kind."""
    if content is None:
        return {}
    try:
        codes = marshal.loads(content)
    except (ValueError, EOFError, TypeError):
        return {}
    if isinstance(codes, dict) and all(type(each) is CodeType for each in codes.values()):
        return codes
    return {}
