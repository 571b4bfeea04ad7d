"""Missing names that have one type: what the uses of one show is true of all.

`a := b` and `a = b` say that both sides have one type, wherever their own parts are used.

Source: IEC 61131-3 (2013) tables 11 and 72: assignment and comparison of derived types.
"""

from collections.abc import Callable, Iterator, Mapping

from achse.st.missing.uses import MissingUse


def join_uses(
    types: Mapping[str, MissingUse],
    names: Mapping[str, MissingUse],
    is_declared: Callable[[str], bool],
) -> bool:
    """Give all uses that have one type what is known of each; return True if that is new.

    `types` are the missing types, `names` the missing variables, by name in lower case;
    `is_declared` says which types are declared.
    """
    owners = dict(_owned(types, names))
    is_new = False
    done: set[int] = set()
    for use, _ in list(owners.values()):
        if id(use) in done:
            continue
        group = list(_group(use))
        done.update(map(id, group))
        is_new |= _join(group, types, owners, is_declared)
    return is_new


def _owned(
    types: Mapping[str, MissingUse], names: Mapping[str, MissingUse]
) -> Iterator[tuple[int, tuple[MissingUse, str]]]:
    """Yield every part of a missing type or list, with the name that its type would get."""
    waiting = [(use, use.name) for use in types.values()]
    waiting += [(use, use.name if use.members else "Global") for use in names.values()]
    for use in names.values():
        yield id(use), (use, f"Global_{use.name}")
    seen: set[int] = set()
    while waiting:
        use, owner = waiting.pop()
        if id(use) in seen:
            continue
        seen.add(id(use))
        parts = [*use.members.values(), *use.inputs.values(), *use.outputs.values()]
        parts += [*use.arguments, *(one for one in (use.element, use.target) if one is not None)]
        for part in parts:
            name = owner if part is use.element or part is use.target else f"{owner}_{part.name}"
            yield id(part), (part, name)
            waiting.append((part, name))


def _group(use: MissingUse) -> Iterator[MissingUse]:
    """Yield all uses that have the type of one."""
    waiting, seen = [use], {id(use)}
    while waiting:
        one = waiting.pop()
        yield one
        new = [peer for peer in one.peers if id(peer) not in seen]
        seen.update(map(id, new))
        waiting += new


def _join(
    group: list[MissingUse],
    types: Mapping[str, MissingUse],
    owners: Mapping[int, tuple[MissingUse, str]],
    is_declared: Callable[[str], bool],
) -> bool:
    """Give the uses of a group one type; return True if that is new."""
    structures = [one for one in group if one.members and not _is_callable(one)]
    if structures and _name_type(group, structures, types, is_declared):
        return True
    is_new = _share_members(structures)
    if structures and len(group) > 1:
        name = structures[0].kind or owners.get(id(structures[0]), (None, ""))[1]
        is_new |= _declare_type(group, structures[0], name)
    _join_arrays(group)
    return _spread(group) or is_new


def _name_type(
    group: list[MissingUse],
    structures: list[MissingUse],
    types: Mapping[str, MissingUse],
    is_declared: Callable[[str], bool],
) -> bool:
    """Give structures the type that a use of their group names, which then has their members.

    Return False if no use names a missing or a declared type.
    """
    missing = next((one.type for one in group if one.type.lower() in types), "")
    name = missing or next((one.type for one in group if one.type and is_declared(one.type)), "")
    target = types[missing.lower()] if missing else None
    for one in structures if name else ():
        if one is target:
            continue
        if target is not None:
            _add_members(target, one)
        one.members, one.is_written = {}, True
        one.note_type(name)
    return bool(name)


def _share_members(structures: list[MissingUse]) -> bool:
    """Let all structures of a group have the members of the first; return True if one did not."""
    is_new = False
    for one in structures[1:]:
        if one.members is not structures[0].members:
            _add_members(structures[0], one)
            one.members, is_new = structures[0].members, True
    return is_new


def _declare_type(group: list[MissingUse], structure: MissingUse, name: str) -> bool:
    """Let uses without a type have the structure, as a type of this name."""
    is_new = False
    for one in group:
        if not _is_callable(one) and not one.type and name and one.kind != name:
            one.kind, one.members, is_new = name, structure.members, True
    return is_new


def _join_arrays(group: list[MissingUse]) -> None:
    """Give arrays of one type the same bounds, and their elements one type."""
    arrays = [one for one in group if one.element is not None]
    elements = [one.element for one in group if one.element is not None]
    highest = max((one.highest for one in arrays), default=0)
    is_open = any(one.is_indexed_by_variable for one in arrays)
    for one in arrays:
        one.highest, one.is_indexed_by_variable = highest, is_open
    for element in elements[1:]:
        if element is not elements[0] and not any(one is element for one in elements[0].peers):
            elements[0].peers.append(element)
            element.peers.append(elements[0])


def _spread(group: list[MissingUse]) -> bool:
    """Give a type that a use shows to those of a group without one."""
    sure = next((one.type for one in group if one.is_sure and not one.type.startswith("ARRAY")), "")
    is_new = False
    for one in group if sure else ():
        if not one.is_sure and not one.members and one.element is None and not one.is_mixed:
            one.type, is_new = sure, True
    return is_new


def _is_callable(use: MissingUse) -> bool:
    """Return True for an instance, whose calls show its parameters."""
    return bool(use.inputs or use.outputs or use.arguments) and not use.is_method


def _add_members(target: MissingUse, other: MissingUse) -> None:
    """Add what is known of one use to another: the same type."""
    for key, part in list(other.members.items()):
        mine = target.members.setdefault(key, part)
        if mine is part:
            continue
        mine.note_type(part.type)
        mine.is_written |= part.is_written
        mine.is_called |= part.is_called
        mine.is_method |= part.is_method
        mine.highest = max(mine.highest, part.highest)
        mine.dimensions = max(mine.dimensions, part.dimensions)
        mine.is_indexed_by_variable |= part.is_indexed_by_variable
        mine.element = mine.element or part.element
        mine.target = mine.target or part.target
        for known, new in ((mine.inputs, part.inputs), (mine.outputs, part.outputs)):
            for name, one in new.items():
                known.setdefault(name, one)
        if len(part.arguments) > len(mine.arguments):
            mine.arguments = part.arguments
        mine.peers.append(part)
        if part.members:
            _add_members(mine, part)
