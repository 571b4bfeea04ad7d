"""Methods and properties that clients may call: those whose declaration says so.

Source: IEC 61131-3 (2013) table 48; the pragma as in TwinCAT 3.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from achse.iec.methods import Method, Parameter, Property
from achse.st.declared.scopes import Scope
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import Method as MethodTree
from achse.st.syntax.units import Part
from achse.st.syntax.units import Property as PropertyTree

if TYPE_CHECKING:
    from achse.st.declared.resolve import Resolver

_PARAMETERS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


def methods_of(names: "Resolver", parts: Iterable[Part], scope: Scope) -> list[Method]:
    """Return the methods with attribute `TcRpcEnable`."""
    return [
        _method(names, part, scope)
        for part in parts
        if isinstance(part, MethodTree) and _is_rpc(part)
    ]


def _method(names: "Resolver", tree: MethodTree, scope: Scope) -> Method:
    inside = Scope(scope.source, f"{scope.owner}.{tree.name}", scope.space, scope)
    parameters = []
    for block in tree.blocks:
        if block.section not in _PARAMETERS:
            continue
        for declaration in block.variables:
            type = names.type_of(declaration.type, inside, inside.owner)
            parameters += [
                Parameter(
                    item.name,
                    type,
                    is_output=block.section == "VAR_OUTPUT",
                    by_reference=block.section == "VAR_IN_OUT",
                    comment=declaration.note.comment,
                    attributes=attributes_of(declaration.note),
                )
                for item in declaration.names
            ]
    returns = None if tree.returns is None else names.type_of(tree.returns, inside, inside.owner)
    return Method(
        tree.name, tuple(parameters), returns, tree.note.comment, attributes_of(tree.note)
    )


def _is_rpc(tree: MethodTree) -> bool:
    return any(name.lower() == "tcrpcenable" for name, _ in tree.note.attributes)


def properties_of(names: "Resolver", parts: Iterable[Part], scope: Scope) -> list[Property]:
    """Return the properties with attribute `monitoring` = `call`, on the property or on GET or
    SET."""
    return [
        Property(
            part.name,
            names.type_of(part.type, scope, f"{scope.owner}.{part.name}"),
            part.get is not None,
            part.set is not None,
            part.note.comment,
            attributes_of(part.note),
        )
        for part in parts
        if isinstance(part, PropertyTree) and _is_called(part)
    ]


def _is_called(tree: PropertyTree) -> bool:
    notes = [part.note for part in (tree, tree.get, tree.set) if part is not None]
    return any(
        (name.lower(), value.lower()) == ("monitoring", "call")
        for note in notes
        for name, value in note.attributes
    )
