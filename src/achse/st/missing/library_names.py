"""Missing names that belong to libraries a project references and that are not here.

A name belongs to such a library if the library is named in front of it, or if it is like the names
that the library is known to have. Of libraries that nothing is known of, it may be any type, any
function that is called, and any list or enumeration; a name close to one that is declared is a
misspelling rather.

Of a library that comes with achse, and lacks some of its names, a name is missing if it has the
form of those and is not a misspelling of one that is here; no plain variable is.

Source: names as public projects use them of the libraries that their `.plcproj` references.
"""

import re
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from difflib import get_close_matches
from itertools import islice

from achse.st.declared.scopes import Scope, with_bases
from achse.st.missing.built_in import is_built_in
from achse.st.missing.kinds import is_list
from achse.st.missing.meanings import Meanings
from achse.st.missing.uses import MissingUse

_CLOSE = 0.9
_MISSPELT = 0.95
_CONSTANT = re.compile(r"[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+")
_GLOBAL = re.compile(r"[gG]_?[A-Z][a-z]|G_|g_")
_DIGITS = "0123456789"


def keep_names_of(
    patterns: Sequence[re.Pattern[str]],
    meanings: Meanings,
    declared: Iterable[str],
    *,
    is_any: bool,
    lacking: Sequence[re.Pattern[str]] = (),
    here: Iterable[str] = (),
    spaces: Iterable[str] = (),
) -> None:
    """Leave out every missing name that belongs to none of the libraries.

    `patterns` are those of their names; with `is_any`, nothing is known of one of them. `lacking`
    are those of libraries that come with achse, which has the names `here` and these name `spaces`,
    in lower case. Without a library,
    interfaces and blocks with methods of symbol files are left.
    """
    own = [name.lower() for name in declared]
    known = [name.lower() for name in here]
    for space in spaces:
        _keep_functions(meanings.names, space, frozenset(known))

    def is_lacking(name: str) -> bool:
        key = name.lower()
        return any(pattern.fullmatch(name) for pattern in lacking) and not any(
            other.rstrip(_DIGITS) != key.rstrip(_DIGITS)
            for other in get_close_matches(key, known, 1, _MISSPELT)
        )

    def belongs(key: str, use: MissingUse, *, is_free: bool) -> bool:
        if any(pattern.fullmatch(key) for pattern in patterns):
            return True
        if (is_free or use.name.isupper()) and is_lacking(use.name):
            return True
        if not (is_any and is_free):
            return False
        alike = (name for name in own if name[:1] == key[:1])
        return _is_shared(use) or not get_close_matches(key, alike, 1, _CLOSE)

    def is_free(key: str, use: MissingUse) -> bool:
        if key in meanings.lists and not use.is_called:
            return is_list(use) or _is_shared(use)  # and no instance that is not declared
        return use.is_called or use.is_bound or _is_global_by_name(use) or _is_shared(use)

    _keep(
        meanings.types.uses,
        lambda key, use: (
            use.is_opaque
            or (use.block is not None and (bool(patterns) or _has_methods(use)))
            or (bool(use.library) and bool(patterns))
            or any(pattern.fullmatch(use.library) for pattern in lacking)
            or belongs(key, use, is_free=True)
        ),
    )
    _keep(meanings.names, lambda key, use: belongs(key, use, is_free=is_free(key, use)))


def _keep_functions(names: dict[str, MissingUse], space: str, here: Container[str]) -> None:
    """Keep of what is named behind a library that comes with achse the functions that it lacks."""
    if space in names:
        _keep(
            names[space].members,
            lambda key, use: (
                use.is_called and not use.members and key not in here and not is_built_in(key)
            ),
        )
        if not names[space].members:
            del names[space]


def _is_global_by_name(use: MissingUse) -> bool:
    """Return True for `ERR_NO_TOOL`, which nothing writes, and `gTime`: so constants and variables
    of lists are named."""
    is_constant = _CONSTANT.fullmatch(use.name) and not use.is_written and not use.members
    return bool(is_constant or _GLOBAL.match(use.name))


def _is_shared(use: MissingUse) -> bool:
    """Return True if two units use a name that no variable of theirs resembles: a variable of a
    list rather than one whose declaration is forgotten."""
    key = use.name.lower()

    def alike(scope: Scope) -> Iterator[str]:
        names = (name for inner in with_bases(scope) for name in inner.variables)
        return (name for name in names if name[:1] == key[:1])

    strange = (
        scope for scope in use.units.values() if not get_close_matches(key, alike(scope), 1, _CLOSE)
    )
    return sum(1 for _ in islice(strange, 2)) > 1


def _has_methods(use: MissingUse) -> bool:
    return any(one.is_called and not one.members for one in use.members.values())


def _keep(uses: dict[str, MissingUse], is_kept: Callable[[str, MissingUse], bool]) -> None:
    for key in [key for key, use in uses.items() if not is_kept(key, use)]:
        del uses[key]
