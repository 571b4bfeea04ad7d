"""Uses in drawn bodies: names in the texts of boxes, operands and pins, with their symbols.

The checker knows what names mean, but of a place only its element. So each name in a text of the
drawing means what the same path means elsewhere in the body; one that means several things (a pin
that boxes of two blocks have) has no place.
"""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from achse.st.check.checking import NameUse
from achse.st.graphical.body import GraphicalBody
from achse.st.syntax.tree import Argument, Literal
from achse.st.values.constants import path_of
from achse.st.workspace.symbols import DeclaredSymbol, symbol_of

_SCALAR = re.compile(
    r"<v(?P<facts>(?:\s[^>]*)?)(?<!/)>(?P<text>[^<]*)</v>|<[A-Za-z][^>]*>([^<]+)(?=<)"
)
"""Texts of an archive, those with a type are values of enumerations; and of other forms."""
_UNREAD = re.compile(r'\bt="|\bn="(?:Comment|SymbolComment|Title|Description|Address|Label)"')
_PATH = re.compile(r"[A-Za-z_]\w*(?:\s*\.\s*[A-Za-z_]\w*)*")
_WORD = re.compile(r"\w+")

_Path = tuple[str, ...]


class DrawnName(NamedTuple):
    """A name in a drawn body, by its offset in the source."""

    at: int
    end: int
    symbol: DeclaredSymbol


def drawn_names(body: GraphicalBody, uses: Iterable[NameUse]) -> Iterator[DrawnName]:
    """Return the names in a drawing, from what the checker found in its statements."""
    meanings = {key: symbols for key, symbols in _meanings(uses).items() if len(symbols) == 1}
    for at, words in _paths(body):
        for count in range(1, len(words) + 1):
            symbols = meanings.get(tuple(word[0].lower() for word in words[:count]))
            if symbols:
                word = words[count - 1]
                start = body.start + at + word.start()
                yield DrawnName(start, start + len(word[0]), symbols[0])


def ambiguous_names(body: GraphicalBody, uses: Iterable[NameUse]) -> set[str]:
    """Return the names, in lower case, that mean several things in a drawing."""
    return {key[-1] for key, symbols in _meanings(uses).items() if len(symbols) > 1}


def _meanings(uses: Iterable[NameUse]) -> dict[_Path, list[DeclaredSymbol]]:
    meanings: dict[_Path, list[DeclaredSymbol]] = {}
    for use in uses:
        symbol = symbol_of(use)
        if symbol is None:
            continue
        if isinstance(use.tree, Argument):
            path: tuple[str, ...] | None = (use.tree.name,)
        elif isinstance(use.tree, Literal):
            path = tuple(_WORD.findall(use.tree.text))
        else:
            path = path_of(use.tree)
        if path:
            known = meanings.setdefault(tuple(word.lower() for word in path), [])
            if symbol not in known:
                known.append(symbol)
    return meanings


def _paths(body: GraphicalBody) -> Iterator[tuple[int, list[re.Match[str]]]]:
    """Yield the dotted names in the texts of a drawing, with the offset of each text."""
    for scalar in _SCALAR.finditer(body.text):
        group = "text" if scalar["text"] is not None else 3
        if scalar["facts"] and _UNREAD.search(scalar["facts"]):
            continue
        for path in _PATH.finditer(scalar[group]):
            base = scalar.start(group) + path.start()
            yield base, list(_WORD.finditer(path[0]))
