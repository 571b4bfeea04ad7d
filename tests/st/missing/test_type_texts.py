"""Types as text, of declarations and of expressions."""

import pytest

from achse.st.declare import examine
from achse.st.missing.meanings import Meanings
from achse.st.missing.type_texts import expression_text, spec_text
from achse.st.syntax.parser import parse
from achse.st.syntax.tree import Expression


@pytest.mark.parametrize(
    ("declared", "text"),
    [
        ("INT", "INT"),
        ("STRING(20)", "STRING(20)"),
        ("STRING(cLong)", ""),
        ("POINTER TO REAL", "POINTER TO REAL"),
        ("REFERENCE TO REAL", "REAL"),
        ("ARRAY [1..3] OF Lib.ST_A", "ARRAY [1..3] OF ST_A"),
    ],
)
def test_type_of_a_declaration(declared: str, text: str) -> None:
    source = (
        f"PROGRAM P VAR CONSTANT cLong : INT := 3; END_VAR VAR v : {declared}; END_VAR END_PROGRAM"
    )
    meanings = Meanings(examine([parse(source)])[0].names)
    scope = meanings.scopes.scope(meanings.scopes.entries["p"])
    assert spec_text(meanings, (scope.variables["v"][1].type, scope)) == text


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ("3", "DINT"),
        ("NOT x", "BOOL"),
        ("-r", "LREAL"),
        ("x < y", "BOOL"),
        ("x + y + r", "LREAL"),
        ("r + x + y", "LREAL"),
        ("x AND y", "BOOL"),
        ("CONCAT(x, y)", "STRING(255)"),
        ("x", ""),
    ],
)
def test_type_that_an_expression_shows(expression: str, text: str) -> None:
    source = f"PROGRAM P VAR r : LREAL; v : INT := {expression}; END_VAR END_PROGRAM"
    meanings = Meanings(examine([parse(source)])[0].names)
    scope = meanings.scopes.scope(meanings.scopes.entries["p"])
    tree = scope.variables["v"][1].initial
    assert isinstance(tree, Expression)
    assert expression_text(meanings, tree, scope) == text
