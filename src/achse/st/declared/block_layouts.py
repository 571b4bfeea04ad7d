"""Layouts of library blocks: sizes of the real blocks, and bases laid out with their block.

Attribute `size` (`size_32` with 32-bit pointers) gives the bytes that instances of the real block
have: its interface, and room for private variables, which are ours. Members of a base with
attribute `joint_layout` are laid out with those of the block that extends it: the interface of all
levels first, then the private variables.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from achse.iec.layout import LayoutRules, TypeLayout, align, sequential
from achse.iec.variables import Section, Variable
from achse.st.declared.scopes import DeclaredUnit
from achse.st.syntax.tree import Note, VarBlock
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import FunctionBlock

_JOINT = "joint_layout"
_SIZES = {8: "size", 4: "size_32"}
_NO_SYMBOL = "TcNoSymbol"
_OF_THE_COMPILER = frozenset((*_SIZES.values(), _JOINT, "builtin"))
"""Attributes that clients do not see."""

_ORDER = {Section.IN_OUT: 0, Section.INPUT: 1, Section.OUTPUT: 2}


def has_joint_layout(entry: DeclaredUnit | None) -> bool:
    """True if a unit is a base whose members are laid out with those of the block extending it."""
    if entry is None or not isinstance(entry.tree, FunctionBlock):
        return False
    return any(name == _JOINT for name, _ in entry.tree.note.attributes)


def is_without_symbols(block: VarBlock) -> bool:
    """True if attribute `TcNoSymbol` is in front of the whole VAR section."""
    return any(name == _NO_SYMBOL for name, _ in block.note.attributes)


def type_attributes(note: Note) -> Mapping[str, str]:
    """Return the attributes of a type that clients see."""
    attributes = attributes_of(note)
    return {key: value for key, value in attributes.items() if key not in _OF_THE_COMPILER}


def least_size(note: Note, rules: LayoutRules) -> int:
    """Return the size in bytes that attribute `size` or `size_32` gives; 0 without it."""
    wanted = _SIZES[rules.pointer_size]
    return next((int(value) for name, value in note.attributes if name == wanted), 0)


def joint_layouts(
    levels: Sequence[Sequence[Variable[Any, Any]]], rules: LayoutRules, size: int
) -> list[TypeLayout]:
    """Return the layout of each level of a block, its root first: all of them have `size` bytes.

    `size` counts if the members need no more.
    """
    inside = [
        (level, member)
        for level, members in enumerate(levels)
        for member in members
        if member.in_memory
    ]
    inside.sort(key=lambda item: _ORDER.get(item[1].section, len(_ORDER)))
    pointer = rules.pointer_size
    whole = sequential(
        (member.type for _, member in inside), rules.pack, start=pointer, alignment=pointer
    )
    size = align(max(whole.size, size), whole.alignment)
    places = {id(member): spot for (_, member), spot in zip(inside, whole.spots, strict=True)}
    return [
        TypeLayout(
            size,
            whole.alignment,
            tuple(places[id(member)] for member in members if member.in_memory),
        )
        for members in levels
    ]
