"""Missing names that belong to libraries a project references and that are not here.

A name belongs to such a library if the library is named in front of it, or if it is like the names
that the library is known to have. Of libraries that nothing is known of, it may be any type, any
function that is called, and any list or enumeration; a name close to one that is declared is a
misspelling rather.

Source: names as public projects use them of the libraries that their `.plcproj` references.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches

from achse.st.unknown.meanings import Meanings
from achse.st.unknown.standins import is_list
from achse.st.unknown.uses import MissingUse

__all__ = ["keep_names_of"]

_CLOSE = 0.9


def keep_names_of(
    patterns: Sequence[re.Pattern[str]],
    meanings: Meanings,
    declared: Iterable[str],
    *,
    is_any: bool,
) -> None:
    """Leave out every missing name that belongs to none of the libraries.

    `patterns` are those of their names; with `is_any`, nothing is known of one of them. Without a
    library, interfaces and blocks with methods of symbol files are left.
    """
    own = [name.lower() for name in declared]

    def belongs(key: str, *, is_free: bool) -> bool:
        if any(pattern.fullmatch(key) for pattern in patterns):
            return True
        alike = (name for name in own if name[:1] == key[:1])
        return is_any and is_free and not get_close_matches(key, alike, 1, _CLOSE)

    def is_free(key: str, use: MissingUse) -> bool:
        if key in meanings.lists and not use.is_called:
            return is_list(use)  # and no instance that is not declared
        return use.is_called

    _keep(
        meanings.types,
        lambda key, use: (
            use.is_opaque
            or (use.block is not None and (bool(patterns) or _has_methods(use)))
            or (use.is_qualified and bool(patterns))
            or belongs(key, is_free=True)
        ),
    )
    _keep(meanings.names, lambda key, use: belongs(key, is_free=is_free(key, use)))


def _has_methods(use: MissingUse) -> bool:
    return any(one.is_called and not one.members for one in use.members.values())


def _keep(uses: dict[str, MissingUse], is_kept: Callable[[str, MissingUse], bool]) -> None:
    for key in [key for key, use in uses.items() if not is_kept(key, use)]:
        del uses[key]
