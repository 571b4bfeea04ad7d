"""Changed names: what an edit of declarations gives another meaning, as routines would name it.

A routine is checked again if its text has a changed name. A name in front of a dot (`name.`)
counts apart: who names a list or a block only to reach into it is not concerned with all that
became other there.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

from achse.st.syntax.outlines import outline_of
from achse.st.syntax.tree import (
    ArrayOf,
    Declaration,
    EnumOf,
    Note,
    PointerTo,
    ReferenceTo,
    StructOf,
    TypeSpec,
    UnionOf,
    VarBlock,
)
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import Accessor, Function, Method, Part, Property, TypeDeclaration, Unit

_WORD = re.compile(r"\w+")
_LOCALS = ("VAR", "VAR_TEMP")


class UnitMember(NamedTuple):
    """A variable or part of a unit: the names by which it is reached, in lower case, and the words
    of its declaration."""

    names: frozenset[str]
    words: frozenset[str]


class UnitMembers(NamedTuple):
    """Words in the head of a unit, and its members."""

    head: frozenset[str]
    members: tuple[UnitMember, ...]
    names: frozenset[str]
    """The unit's own name, and those of its contents that need no prefix."""
    is_single: bool
    """True if nothing in the unit is reached apart from it: a function, an enumeration, an
    alias."""


Seen: TypeAlias = Mapping[str, tuple[object, ...]]
"""All that others see of each variable and part of a unit, by name in lower case."""


class ChangedNames(NamedTuple):
    """Names and parts that an edit changes, all in lower case."""

    names: set[str]
    """Names that mean something else, those in front of a dot with it."""
    wholes: set[str]
    """Keys of units of which each routine may see something else."""

    @property
    def words(self) -> set[str]:
        """The names without dots."""
        return {name.removesuffix(".") for name in self.names}


def changed_names(
    before: Mapping[str, Unit],
    after: Mapping[str, Unit],
    wholes: Collection[str],
    touched: Mapping[str, UnitMembers],
) -> ChangedNames:
    """Return the names that an edit changes: in a file with these units before and after, and in
    units that it touches, after the edit. Of `wholes`, keys, everything may be other."""
    changed = ChangedNames({key.rpartition(".")[2] for key in touched}, set())
    for key in wholes:
        if key in touched:
            _change_whole(changed, key, touched[key].names)
    for key in before.keys() | after.keys():
        pair = [units[key] for units in (before, after) if key in units]
        is_apart = len(pair) == 1 or "." in key or key in wholes
        different = None if is_apart else differing(*pair)
        if different is None:
            for unit in pair:
                _change_whole(changed, key, names_of(unit))
        else:
            changed.names.update(different, (f"{name}." for name in different))
    _spread(changed, touched)
    return changed


def names_of(unit: Unit) -> frozenset[str]:
    """Return the names by which others reach a unit and its contents, in lower case."""
    outline = outline_of(unit)
    return frozenset(
        (outline.name.lower(), *outline.variables, *outline.properties, *outline.values)
    )


def _change_whole(changed: ChangedNames, key: str, names: Iterable[str]) -> None:
    changed.wholes.update((key, key.rpartition(".")[2]))
    for name in names:
        changed.names.update((name, f"{name}."))


def _spread(changed: ChangedNames, touched: Mapping[str, UnitMembers]) -> None:
    """Add the members of touched units whose declarations name something that is changed."""
    members = [member for unit in touched.values() for member in unit.members]
    before = -1
    while len(changed.names) + len(changed.wholes) > before:
        before = len(changed.names) + len(changed.wholes)
        words = changed.words
        inside = {word for word in words if f"{word}." in changed.names} | changed.wholes
        for key, unit in touched.items():
            causes = inside if unit.is_single else changed.wholes
            if key not in changed.wholes and not causes.isdisjoint(unit.head):
                _change_whole(changed, key, unit.names)
        for member in members:
            if not words.isdisjoint(member.words):
                changed.names.update(member.names)
                if not inside.isdisjoint(member.words):
                    changed.names.update(f"{name}." for name in member.names)


def members_of(unit: Unit) -> UnitMembers:
    """Return what the declarations of a unit say of each of its members."""
    if _is_single(unit):
        return UnitMembers(frozenset(words_in(unit)), (), names_of(unit), True)
    variables = (
        UnitMember(frozenset(_names_in(declaration)), frozenset(_words_of(declaration)))
        for block in blocks_of(unit)
        for declaration in block.variables
    )
    parts = (
        UnitMember(frozenset((part.name.lower(),)), frozenset(_words_of_part(part)))
        for part in getattr(unit, "parts", ())
    )
    head = frozenset(words_in(tuple(_head(unit)[1:])))
    return UnitMembers(head, (*variables, *parts), names_of(unit), False)


def unchanged_parts(before: Unit, after: Unit) -> frozenset[str]:
    """Return the names of the parts that are the same, bodies included; an empty one stands for
    the body of the unit itself. All in lower case."""
    later = {part.name.lower(): part for part in getattr(after, "parts", ())}
    unchanged = {
        part.name.lower()
        for part in getattr(before, "parts", ())
        if part == later.get(part.name.lower())
    }
    if getattr(before, "body", None) == getattr(after, "body", None):
        unchanged.add("")
    return frozenset(unchanged)


def words_in(tree: Any, *, is_code: bool = False) -> Iterator[str]:
    """Words of a syntax tree, in lower case, without comments; those of bodies with `is_code`."""
    waiting: list[Any] = [tree]
    while waiting:
        tree = waiting.pop()
        if isinstance(tree, str):
            yield from _WORD.findall(tree.lower())
        elif isinstance(tree, Note):
            waiting.append(tree.attributes)
        elif isinstance(tree, tuple):
            waiting += tree
        elif hasattr(tree, "__match_args__"):
            names = (name for name in tree.__match_args__ if is_code or name != "body")
            waiting += [getattr(tree, name) for name in names]


_INSIDE = ("at", "body", "blocks", "parts")


def _is_single(unit: Unit) -> bool:
    """Return True if a unit has no members that are named apart from it."""
    if isinstance(unit, TypeDeclaration):
        return not isinstance(unit.type, StructOf | UnionOf)
    return isinstance(unit, Function)


def differing(before: Unit, after: Unit) -> Collection[str] | None:
    """Return the names of the members that are other; None if more may be."""
    if before.__class__ is not after.__class__ or _is_single(before):
        return () if before == after else None
    if _head(before) != _head(after):
        return None
    first, second = _seen(before), _seen(after)
    if first is None or second is None:
        return None
    keys: set[str] = set()
    for key in first.keys() | second.keys():
        if first.get(key) != second.get(key):
            keys.add(key)
    for unit in (before, after):
        for block in blocks_of(unit):
            for declaration in block.variables:
                names = set(_names_in(declaration))
                if not keys.isdisjoint(names):
                    keys |= names
    return keys


def _head(unit: Any) -> list[object]:
    """Return the declaration of a unit, its name first."""
    if isinstance(unit, TypeDeclaration):
        return [
            unit.name,
            unit.modifiers,
            unit.extends,
            unit.initial,
            unit.note,
            unit.type.__class__,
        ]
    return [getattr(unit, name) for name in unit.__match_args__ if name not in _INSIDE]


def _seen(unit: Any) -> Seen | None:
    """Return all that others see of a unit; None if two of its members have one name."""
    contents: dict[str, tuple[object, ...]] = {}
    for block in blocks_of(unit):
        for declaration in block.variables:
            for item in declaration.names:
                key = item.name.lower()
                if key in contents:
                    return None
                contents[key] = (block.section, block.qualifiers, block.note, declaration)
    for part in getattr(unit, "parts", ()):
        key = part.name.lower()
        if key in contents:
            return None
        contents[key] = (part.__class__, *_seen_of(part))
    return contents


def _seen_of(part: Any) -> Iterator[object]:
    for name in part.__match_args__:
        if name in ("at", "body"):
            continue
        value = getattr(part, name)
        if name == "blocks":
            yield _shared(value)
        elif isinstance(value, Accessor):
            yield tuple(_seen_of(value))
        else:
            yield value


def _names_in(declaration: Declaration) -> Iterator[str]:
    """Yield the names of variables, and the values of an enumeration that is declared there."""
    for item in declaration.names:
        yield item.name.lower()
    spec: TypeSpec = declaration.type
    while isinstance(spec, ArrayOf | PointerTo | ReferenceTo):
        spec = spec.element if isinstance(spec, ArrayOf) else spec.target
    if isinstance(spec, EnumOf):
        yield from (value.name.lower() for value in spec.values)


def _words_of(declaration: Declaration) -> Iterator[str]:
    for name in declaration.__match_args__:
        if name != "names":
            yield from words_in(getattr(declaration, name))


def _words_of_part(part: Part) -> Iterator[str]:
    """Words in what others see of a part."""
    if isinstance(part, Property):
        yield from words_in((part.type, part.initial, part.note))
    elif isinstance(part, Method):
        yield from words_in((part.returns, part.note))
        yield from words_in(_shared(part.blocks))


def _shared(blocks: Iterable[VarBlock]) -> tuple[VarBlock, ...]:
    """Return the variables of a part that others see."""
    return tuple(block for block in blocks if block.section not in _LOCALS)
