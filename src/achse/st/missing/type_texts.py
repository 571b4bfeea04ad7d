"""Texts of types: what a stub declares for a type, or for the type that an expression shows.

Source: IEC 61131-3 (2013) tables 11 and 71: types, and the types of results of operators.
"""

from dataclasses import replace

from achse.st.declared.scopes import Scope
from achse.st.missing.built_in import result_text
from achse.st.missing.meanings import Meanings
from achse.st.missing.trees import is_plain, literal_text
from achse.st.missing.uses import MissingUse
from achse.st.syntax.printer import print_type
from achse.st.syntax.tree import (
    ArrayOf,
    Binary,
    Call,
    Expression,
    Literal,
    Name,
    NamedType,
    PointerTo,
    ReferenceTo,
    StringOf,
    TypeSpec,
    Unary,
)

LOGICAL = ("AND", "OR", "XOR", "AND_THEN", "OR_ELSE", "&")
_COMPARING = ("=", "<>", "<", "<=", ">", ">=")
_LONG_SUM = 8
"""Most operands of an expression with types."""


def spec_text(meanings: Meanings, at: tuple[TypeSpec, Scope]) -> str:
    """Return a type as text that means the same elsewhere; nothing if it cannot."""
    spec, scope = at
    if isinstance(spec, ReferenceTo):
        return spec_text(meanings, (spec.target, scope))
    if isinstance(spec, StringOf) and (spec.length is None or isinstance(spec.length, Literal)):
        return print_type(spec)
    if isinstance(spec, PointerTo) and (inner := spec_text(meanings, (spec.target, scope))):
        return f"POINTER TO {inner}"
    if isinstance(spec, NamedType) and not spec.generics:
        return spec.name.rpartition(".")[2] if meanings.types.is_missing(spec, scope) else spec.name
    if isinstance(spec, ArrayOf) and (inner := spec_text(meanings, (spec.element, scope))):
        if inner.startswith("ARRAY [*"):
            return ""
        is_known = all(is_plain(one, meanings.scopes) for one in spec.dimensions)
        bounds = spec.dimensions if is_known else (None,) * len(spec.dimensions)
        return print_type(replace(spec, dimensions=bounds, element=NamedType(inner)))
    return ""


def expression_text(meanings: Meanings, tree: Expression, scope: Scope) -> str:
    """Return the type of an expression, where it shows."""
    if isinstance(tree, Literal):
        return literal_text(tree)
    if isinstance(tree, Unary):
        return "BOOL" if tree.operator == "NOT" else expression_text(meanings, tree.operand, scope)
    if isinstance(tree, Binary):
        if tree.operator in _COMPARING:
            return "BOOL"
        for _ in range(_LONG_SUM):
            if text := expression_text(meanings, tree.right, scope):
                return text
            if not isinstance(tree.left, Binary):
                break
            tree = tree.left
        left = "" if isinstance(tree.left, Binary) else expression_text(meanings, tree.left, scope)
        return left or ("BOOL" if tree.operator.upper() in LOGICAL else "")
    callee = tree.of if isinstance(tree, Call) else None
    if isinstance(callee, Name) and (result := result_text(callee.name)):
        return result
    sense = meanings.of(tree, scope)
    if isinstance(sense, tuple):
        return spec_text(meanings, sense)
    return sense.type if isinstance(sense, MissingUse) else ""
