"""Parts of trees: variables of a unit, attributes of a declaration.

Source: IEC 61131-3 (2013) table 13; attributes as the vendor's compiler spells them.
"""

from collections.abc import Sequence

from achse.st.syntax.tree import NO_NOTE, Note, StructOf, UnionOf, VarBlock
from achse.st.syntax.units import TypeDeclaration, Unit


def blocks_of(unit: Unit) -> Sequence[VarBlock]:
    """Return the variables of a unit; the members of a structure or union are one block."""
    if isinstance(unit, TypeDeclaration):
        spec = unit.type
        if isinstance(spec, StructOf | UnionOf):
            return (VarBlock("VAR", (), spec.members, NO_NOTE, spec.at),)
        return ()
    blocks: Sequence[VarBlock] = getattr(unit, "blocks", ())
    return blocks


def attributes_of(note: Note) -> dict[str, str]:
    """Return attributes by name; the one that decides a layout in its usual spelling."""
    if not note.attributes:
        return {}
    return {
        name.lower() if name.lower() == "pack_mode" else name: value
        for name, value in note.attributes
    }
