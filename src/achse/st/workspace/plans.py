"""Plans: which routines an edit of declarations makes the checker check again.

A routine of a unit that is declared again keeps its findings if its text has no changed name.
"""

from collections.abc import Container, Iterable, Mapping
from typing import NamedTuple

from achse.st.check.signatures import Signature
from achse.st.check.warm import WarmChecking
from achse.st.declared.resolve import Resolver, generics_of
from achse.st.declared.scopes import DeclaredUnit
from achse.st.lexis.source import Source
from achse.st.syntax.parser import Parsed
from achse.st.syntax.units import (
    Action,
    Function,
    GlobalList,
    Method,
    Program,
    Property,
    Unit,
)
from achse.st.workspace.changed import ChangedNames, changed_names, unchanged_parts
from achse.st.workspace.touched import Touched, WordIndex, units_of

_INSTANCES = frozenset(("this", "super"))


class RoutinePlan(NamedTuple):
    """Routines after an edit of declarations."""

    again: list[Signature]
    """Routines to check again, in units that are not declared again."""
    unchanged: list[Signature]
    """Routines with the same findings, in units that are declared again."""


def plan_routines(
    checking: WarmChecking, known: Parsed, edited: Parsed, touched: Touched, index: WordIndex
) -> RoutinePlan:
    """Return what to do with the routines of a project, before an edit of a file is declared."""
    before, after = dict(units_of(known)), dict(units_of(edited))
    names = checking.names
    entries = {key: names.scopes.entries.get(key) for key in touched.units}
    unsound = {key for key, one in entries.items() if one and not is_sound(names, one)}
    members = {
        key: index.members(after.get(key) or before.get(key) or entry.tree)
        for key, entry in entries.items()
        if entry is not None and (entry.is_used or key in before)
    }
    changed = changed_names(before, after, touched.wholes | unsound, members)
    same = {key: unchanged_parts(before[key], after[key]) for key in before.keys() & after.keys()}
    return _planned(checking, touched, changed, same, known.source, index)


def plan_of_all(checking: WarmChecking, touched: Touched, index: WordIndex) -> RoutinePlan:
    """Return a plan that keeps nothing in the units that an edit touches."""
    names = {*touched.words, *(f"{word}." for word in touched.words)}
    changed = ChangedNames(names, set(touched.units))
    return _planned(checking, touched, changed, {}, None, index)


def settled(
    plan: RoutinePlan, names: Resolver, touched: Touched, edited: Parsed
) -> RoutinePlan | None:
    """Return the plan after its edit was declared, with the trees of the new version; None if a
    unit that had its type has none now."""
    entries = names.scopes.entries
    for key in touched.units - touched.wholes:
        entry = entries.get(key)
        if entry is not None and not is_sound(names, entry):
            return None
    trees = dict(units_of(edited))
    unchanged = []
    for routine in plan.unchanged:
        key = routine.entry.name.lower()
        if entries.get(key) is not routine.entry:
            continue
        if routine.entry.source is edited.source and not _moved(routine, trees.get(key)):
            continue
        unchanged.append(routine)
    return RoutinePlan(plan.again, unchanged)


def any_list_fails(names: Resolver, sound: Iterable[str]) -> bool:
    """Return True if a list that was declared, of these units, could not be declared again."""
    entries = (names.scopes.entries.get(key) for key in sound)
    lists = [one for one in entries if one is not None and isinstance(one.tree, GlobalList)]
    return not all(is_sound(names, one) for one in lists)


def is_sound(names: Resolver, entry: DeclaredUnit) -> bool:
    """Return True if a unit has its type or its record, or needs none."""
    if entry.failed:
        return False
    if entry.is_library or generics_of(entry):
        return True
    if isinstance(entry.tree, GlobalList | Program):
        return entry.name.lower() in names.units
    return entry.type is not None or isinstance(entry.tree, Function)


def _moved(routine: Signature, unit: Unit | None) -> bool:
    """Give a routine its tree in a new version of its unit; False if there is none."""
    owner = routine.accessor_of
    name = _part_of(routine)
    if not name:
        if unit.__class__ is not routine.tree.__class__:
            return False
        routine.tree = unit
        return True
    for part in getattr(unit, "parts", ()):
        if part.name.lower() != name:
            continue
        if owner is None:
            routine.tree = part
            return part.__class__ is routine.tree.__class__
        if not isinstance(part, Property):
            return False
        accessor = part.get if routine.tree is owner.get else part.set
        if accessor is None:
            return False
        routine.tree, routine.accessor_of = accessor, part
        return True
    return False


def _planned(
    checking: WarmChecking,
    touched: Touched,
    changed: ChangedNames,
    same: Mapping[str, Container[str]],
    edited: Source | None,
    index: WordIndex,
) -> RoutinePlan:
    """Return a plan for changed names; `same` are the parts that the edit of a file leaves, by the
    key of their unit. Faults say what has a similar name, anywhere.

    A routine of a unit that is not touched reaches into one by a name of it alone.
    """
    names = changed.names
    inside = names | _INSTANCES
    reach = {*touched.words, *(f"{word}." for word in touched.words)}
    plan = RoutinePlan([], [])
    by_source: dict[Source, list[Signature]] = {}
    for routine in checking.routines.created:
        by_source.setdefault(routine.source, []).append(routine)
    for source, routines in by_source.items():
        texts: Mapping[str, frozenset[str]] | None = None
        is_named = not touched.words.isdisjoint(index.of_file(source))
        for routine in routines:
            node = checking.nodes.get(routine.key)
            if node is None:
                continue
            unit = checking.unit_of(routine.key)
            is_touched = unit in touched.units
            if node.faults and not is_touched:
                plan.again.append(routine)
            if (
                node.faults
                or not (is_touched or is_named)
                or unit in changed.wholes & touched.units
            ):
                continue
            if texts is None:
                texts = index.of_routines(source, routines)
            own = texts.get(routine.key)
            if not is_touched:
                if own is None or not (names.isdisjoint(own) or reach.isdisjoint(own)):
                    plan.again.append(routine)
                continue
            part = _part_of(routine)
            if own is None or "<" in routine.key or part in names or not inside.isdisjoint(own):
                continue
            is_placed = bool(node.warnings or node.remarks)
            if source is not edited or (part in same.get(unit, ()) and not is_placed):
                plan.unchanged.append(routine)
    return plan


def _part_of(routine: Signature) -> str:
    """Return the name of the part that a routine is, in lower case; empty for a unit's body."""
    tree = routine.accessor_of or routine.tree
    return tree.name.lower() if isinstance(tree, Method | Property | Action) else ""
