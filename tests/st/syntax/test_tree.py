"""Nodes of the tree: what they compare by, and the places they know."""

from dataclasses import fields, is_dataclass

import pytest

from achse.st.syntax import tree
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import parse_expression, parse_statements
from tests.public_names import public_names

NODES = [
    node
    for name in public_names(tree)
    if isinstance(node := getattr(tree, name), type) and is_dataclass(node)
]


@pytest.mark.parametrize("node", NODES)
def test_places_do_not_count_and_are_not_shown(node: type) -> None:
    for item in fields(node):
        if item.name == "at":
            assert (item.default, item.compare, item.repr) == (0, False, False)
        else:
            assert item.compare


def test_the_same_text_elsewhere_is_the_same_tree() -> None:
    here = parse_expression("fb.aParts[i + 1]^.nCount")
    there = parse_expression("\n  fb . aParts [ i\n+ 1 ] ^ . nCount")
    assert here == there
    assert hash(here) == hash(there)
    assert here.at != there.at


@pytest.mark.parametrize("node", NODES)
def test_changed_node_differs_in_the_field_alone(node: type) -> None:
    names = [item.name for item in fields(node)]
    first = node(**{name: name for name in names})
    for name in names:
        copy = changed(first, **{name: 5})
        assert type(copy) is node
        assert {key: getattr(copy, key) for key in names} == {
            key: 5 if key == name else key for key in names
        }
    assert [getattr(first, name) for name in names] == names


def test_other_words_are_another_tree() -> None:
    assert parse_expression("a + b") != parse_expression("a - b")
    assert parse_expression("a") != parse_expression(".a")
    assert parse_expression("a.b") != parse_expression("a^.b")


def test_nodes_are_small() -> None:
    assert not hasattr(tree.Name("a"), "__dict__")


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("alpha", "alpha"),
        ("alpha + beta", "+"),
        ("alpha.beta", "beta"),
        ("NOT alpha", "NOT"),
        ("16#FF", "16#FF"),
        ("THIS", "THIS"),
        ("SUPER", "SUPER"),
    ],
)
def test_an_expression_knows_the_sign_that_makes_it_what_it_is(text: str, sign: str) -> None:
    assert parse_expression(text).at == text.index(sign)


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("alpha := 1;", ":="),
        ("; ; IF a THEN EXIT; END_IF", "IF"),
        ("; WHILE a DO b(); END_WHILE", "WHILE"),
        ("; JMP here;", "JMP"),
        ("; RETURN;", "RETURN"),
    ],
)
def test_a_statement_knows_the_sign_that_makes_it_what_it_is(text: str, sign: str) -> None:
    (statement,) = parse_statements(text)
    assert statement.at == text.index(sign)


def test_the_note_of_what_has_none_is_empty() -> None:
    assert tree.Note("", ()) == tree.NO_NOTE
