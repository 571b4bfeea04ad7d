"""Statements while they are written: expressions, edges, conditions."""

import pytest

from achse.st.graphical.body import GraphicalBody, UnitPins
from achse.st.graphical.writer import BodyStatements, implicit_block, path_of
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse_expression
from achse.st.syntax.tree import Assign, If, Let, Member, Name


class NoScope:
    def is_callable(self, name: str) -> bool:
        return False

    def pins(self, name: str) -> UnitPins | None:
        return None


def writer() -> BodyStatements:
    return BodyStatements(GraphicalBody("NWL", b"<NWL>", 100, 1), NoScope())


@pytest.mark.parametrize("text", ["a", "a.b.c", "TRUE", "this^.x", "w.7", "F(a, 2) + TO_REAL(n)"])
def test_all_of_an_expression_is_at_one_place(text: str) -> None:
    expression = writer().expression(text, 123)
    assert expression == parse_expression(text)
    stack = [expression]
    while stack:
        item = stack.pop()
        assert item.at == 123
        stack += [one for one in (getattr(item, "of", None), getattr(item, "left", None)) if one]


def test_a_fault_in_text_is_at_the_place_of_its_node() -> None:
    one = writer()
    one.location = "network 4"
    at = one.at(5)
    with pytest.raises(Unexpected, match="expected an expression") as caught:
        one.expression("a +", at)
    assert caught.value.at == at == 105
    assert one.body.place(at) == "network 4"
    with pytest.raises(Unexpected, match="line 2: "):
        one.parsed_statements("a := 1;\nb := ;", at)


def test_an_edge_writes_value_result_and_memory() -> None:
    one = writer()
    result = one.edge("__m", Name("x"), rises=True, at=1)
    now, edge, memory = one.out
    assert isinstance(now, Let)
    assert isinstance(edge, Let)
    assert result == Name(edge.name)
    assert memory == Assign(":=", Name("__m"), Name(now.name))


def test_what_is_written_under_a_condition_is_in_an_if() -> None:
    one = writer()
    one.when(Name("c"), lambda: one.assign(Name("a"), Name("b"), 1), 1)
    one.when(None, lambda: one.assign(Name("a"), Name("b"), 1), 1)
    one.when(Name("c"), lambda: None, 1)
    first, second = one.out
    assert isinstance(first, If)
    assert first.branches[0].body == (second,)


def test_paths_and_implicit_variables() -> None:
    assert path_of(["a", "b"], 3) == Member(Name("a"), "b")
    block = implicit_block([("__x", "BOOL")])
    assert (block.qualifiers, block.note.attributes) == (("IMPLICIT",), (("TcNoSymbol", ""),))
    assert implicit_block([("S", "SFCStepType")], has_symbols=True).note.attributes == ()
