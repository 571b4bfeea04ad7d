"""Bases that declarations of missing types need."""

from achse.st.declare import examine
from achse.st.missing.required import require_bases
from achse.st.missing.walk import MissingNames
from achse.st.syntax.parser import parse


def test_types_without_a_symbol_file_require_nothing() -> None:
    declarations, _ = examine([parse("PROGRAM P VAR a : FB_A; END_VAR a(b := 1); END_PROGRAM")])
    scopes = declarations.names.scopes
    missing = MissingNames(declarations.names)
    require_bases(missing.meanings.types, scopes.scope(scopes.entries["p"]))
    assert not missing.meanings.types.uses["fb_a"].extends
    assert not missing.meanings.types.is_of_symbol_file("fb_a")
