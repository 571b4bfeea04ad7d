"""Bases and interfaces that declarations of missing types need, by symbol files.

Source: symbol files (`.tmc`) of TwinCAT 3, seen in public projects.
"""

from collections.abc import Iterator

from achse.st.declared.scopes import Scope
from achse.st.missing.types import MissingTypes
from achse.st.missing.uses import MissingUse
from achse.st.syntax.tree import NamedType


def require_bases(types: MissingTypes, scope: Scope) -> None:
    """Require the bases and interfaces of all types that need a declaration, and the blocks
    that implement such an interface."""
    waiting = [use for use in types.uses.values() if use.is_needed]
    done: set[int] = set()
    while waiting:
        use = waiting.pop()
        if id(use) in done:
            continue
        done.add(id(use))
        if use.signature is None:
            continue
        bases = [use.signature.extends] if use.signature.extends else []
        for names, wanted in ((use.extends, bases), (use.implements, use.signature.implements)):
            for name in wanted:
                declared, base = _base(types, name, scope)
                if declared:
                    names.append(name)
                if base is not None:
                    base.is_required = True
                    waiting.append(base)
        if use.is_interface:
            waiting += _require_blocks_of(types, use)


def _base(types: MissingTypes, name: str, scope: Scope) -> tuple[bool, MissingUse | None]:
    """Return True if a base can be declared, and its use if it needs a stub."""
    spec = NamedType(name)
    if not types.is_missing(spec, scope):
        return types.scopes.find(name, scope.space) is not None, None
    is_known = types.is_of_symbol_file(name.rpartition(".")[2].lower())
    return is_known, types.use(spec) if is_known else None


def _require_blocks_of(types: MissingTypes, interface: MissingUse) -> Iterator[MissingUse]:
    key = interface.name.lower()
    for use in types.uses.values():
        names = () if use.signature is None else use.signature.implements
        if not use.is_required and any(one.lower().rpartition(".")[2] == key for one in names):
            use.is_required = True
            yield use
