"""Printed trees are read back as the same trees."""

from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.st.lexis.source import Source
from achse.st.lexis.words import KEYWORDS
from achse.st.syntax import tree
from achse.st.syntax.expressions import BINDING
from achse.st.syntax.parser import Parser, parse, parse_expression, parse_statements
from achse.st.syntax.printer import (
    print_expression,
    print_initial,
    print_statements,
    print_type,
    print_units,
)
from achse.st.syntax.units import FunctionBlock, Method, Program

Draw = st.SearchStrategy[Any]


def quoted(text: str) -> str:
    return "'" + text.replace("$", "$$").replace("'", "$'") + "'"


names = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}", fullmatch=True).filter(
    lambda name: name.upper() not in KEYWORDS | {"TRUE", "FALSE", "S", "R", "REF", "GET", "SET"}
)
paths = st.lists(names, min_size=1, max_size=3).map(".".join)
literals: Draw = st.one_of(
    st.integers(0, 10**9).map(lambda n: tree.Literal("integer", str(n))),
    st.integers(0, 2**64 - 1).map(lambda n: tree.Literal("integer", f"16#{n:X}")),
    st.floats(0, 1e12).map(lambda x: tree.Literal("real", f"{x:.6f}")),
    st.sampled_from(["TRUE", "FALSE"]).map(lambda text: tree.Literal("boolean", text)),
    st.text("abcä $'\"", max_size=6).map(lambda text: tree.Literal("string", quoted(text))),
    st.sampled_from(["T#1s500ms", "LTIME#5ns", "INT#-5", "WORD#16#FF", "D#2024-02-29",
                     "E_State#Idle", "DT#2024-01-01-12:00", "REAL#1.5E-3"]).map(
        lambda text: tree.Literal("typed", text)
    ),
)  # fmt: skip


def grown(inner: Draw) -> Draw:
    """Expressions around expressions; what a path starts with is a name, THIS or a pointer."""
    starts = st.one_of(
        names.map(tree.Name),
        names.map(tree.GlobalName),
        st.builds(tree.Dereference, st.sampled_from([tree.This(), tree.Super()])),
    )
    arguments = st.one_of(
        st.builds(tree.Argument, st.just(""), inner, st.just(False)),
        st.builds(tree.Argument, names, st.none() | inner, st.booleans()),
    ).filter(lambda item: item.name or not isinstance(item.value, tree.Assign))
    steps = st.recursive(
        starts,
        lambda of: st.one_of(
            st.builds(tree.Member, of, names),
            st.builds(tree.PartOf, of, st.just("X"), st.integers(0, 63)),
            st.builds(tree.PartOf, of, st.sampled_from("BWDL"), st.integers(0, 7)),
            st.builds(tree.Index, of, st.lists(inner, min_size=1, max_size=2).map(tuple)),
            st.builds(tree.Dereference, of | inner),
            st.builds(tree.Call, of, st.lists(arguments, max_size=3).map(tuple)),
        ),
        max_leaves=3,
    )
    operators = st.sampled_from([sign for sign in BINDING if sign != ":="])
    return st.one_of(
        steps,
        st.builds(tree.Binary, operators, inner, inner),
        st.builds(tree.Unary, st.sampled_from(["-", "+", "NOT"]), inner),
        st.builds(tree.Assign, st.just(":="), steps, inner),
    )


expressions: Draw = st.recursive(literals | names.map(tree.Name), grown, max_leaves=6)
values: Draw = st.recursive(literals | names.map(tree.Name), grown, max_leaves=3)
references = st.one_of(names.map(tree.Name), st.builds(tree.Member, names.map(tree.Name), names))
initials: Draw = st.recursive(
    values.filter(lambda item: not isinstance(item, tree.Assign)),
    lambda inner: st.one_of(
        st.builds(
            tree.ArrayInitial,
            st.lists(
                inner.filter(lambda item: not isinstance(item, tree.Repetition))
                | st.builds(
                    tree.Repetition,
                    values.filter(lambda item: not isinstance(item, tree.Name | tree.Member)),
                    st.lists(inner, max_size=2).map(tuple),
                ),
                max_size=3,
            ).map(tuple),
        ),
        st.builds(
            tree.StructInitial,
            st.lists(st.builds(tree.MemberInitial, names, inner), max_size=3).map(tuple),
        ),
    ),
    max_leaves=5,
)
ranges = st.builds(tree.Range, values, values).filter(
    lambda item: not isinstance(item.low, tree.Assign) and not isinstance(item.high, tree.Assign)
)
named = st.builds(
    tree.NamedType,
    paths,
    st.lists(values.filter(lambda item: not isinstance(item, tree.Assign)), max_size=2).map(tuple),
)
plain_values = values.filter(lambda item: not isinstance(item, tree.Assign))
types: Draw = st.recursive(
    st.one_of(
        named,
        st.builds(tree.StringOf, st.sampled_from(["STRING", "WSTRING"]), st.none() | plain_values),
        st.builds(tree.Subrange, st.builds(tree.NamedType, names), ranges),
    ),
    lambda inner: st.one_of(
        st.builds(
            tree.ArrayOf, st.lists(st.none() | ranges, min_size=1, max_size=2).map(tuple), inner
        ),
        st.builds(tree.PointerTo, inner),
        st.builds(tree.ReferenceTo, inner),
    ),
    max_leaves=3,
)
notes = st.builds(
    tree.Note,
    st.from_regex(r"( [a-z(*)/]{1,5})?", fullmatch=True).filter(
        lambda text: "(*" not in text and "*)" not in text
    ),
    st.lists(st.tuples(names, st.text("ab '$\"{}", max_size=4)), max_size=2).map(tuple),
)
declarations = st.builds(
    tree.Declaration,
    st.lists(names.map(tree.Name), min_size=1, max_size=2).map(tuple),
    st.none() | st.sampled_from(["%I*", "%QX1.5", "%MD4"]).map(tree.DirectAddress),
    types,
    st.just(()),
    st.none() | initials,
    notes,
)
blocks = st.builds(
    tree.VarBlock,
    st.sampled_from(["VAR", "VAR_INPUT", "VAR_TEMP"]),
    st.sampled_from([(), ("CONSTANT",), ("PERSISTENT", "RETAIN")]),
    st.lists(declarations, max_size=2).map(tuple),
    notes,
)


def bodies(inner: Draw) -> Draw:
    body = st.lists(inner, max_size=2).map(tuple)
    branches = st.lists(st.builds(tree.Branch, values, body), min_size=1, max_size=2).map(tuple)
    labels = st.lists(plain_labels | ranges, min_size=1, max_size=2).map(tuple)
    choices = st.lists(st.builds(tree.Choice, labels, body), max_size=2).map(tuple)
    return st.one_of(
        st.builds(tree.If, branches, body),
        st.builds(tree.Case, plain_values, choices, body),
        st.builds(tree.For, references, plain_values, plain_values, st.none() | plain_values, body),
        st.builds(tree.While, values, body),
        st.builds(tree.RepeatUntil, body, values),
    )


plain_labels = st.integers(0, 99).map(lambda n: tree.Literal("integer", str(n)))
ranges_of_labels = st.builds(tree.Range, plain_labels, plain_labels)
statements: Draw = st.recursive(
    st.one_of(
        st.builds(tree.Assign, st.sampled_from([":=", "S=", "R=", "REF="]), references, values),
        st.builds(tree.Call, references, st.just(())),
        references,
        st.sampled_from([tree.Exit(), tree.Continue(), tree.Return()]),
        st.builds(tree.Jump, names),
    ),
    bodies,
    max_leaves=5,
)
relaxed = settings(max_examples=27, deadline=None, suppress_health_check=list(HealthCheck))


@given(expressions)
@relaxed
def test_expressions(node: tree.Expression) -> None:
    assert parse_expression(print_expression(node)) == node


@given(initials)
@relaxed
def test_initial_values(node: tree.Initial) -> None:
    parser = Parser(Source(print_initial(node)))
    assert parser.attempt(parser.expressions.initial) == node


@given(types)
@relaxed
def test_types(node: tree.TypeSpec) -> None:
    parser = Parser(Source(print_type(node)))
    assert parser.attempt(parser.declarations.type_spec) == node


@given(st.lists(statements, max_size=4).map(tuple))
@relaxed
def test_statements(nodes: tree.Statements) -> None:
    assert parse_statements(print_statements(nodes)) == nodes


@given(st.lists(blocks, max_size=2).map(tuple), st.lists(statements, max_size=2).map(tuple), notes)
@relaxed
def test_units(
    variables: tuple[tree.VarBlock, ...], body: tree.Statements, note: tree.Note
) -> None:
    method = Method("m", ("PUBLIC",), tree.NamedType("INT"), variables, body, note)
    units = (
        Program("P", (), variables, (), body, note),
        FunctionBlock("F", (), variables, (method,), body, note),
    )
    assert parse(print_units(units)).check().units == units


def test_long_sums_are_printed_without_recursion() -> None:
    text = " - ".join(["x"] * 900)
    assert print_expression(parse_expression(text)) == text


def test_comments_that_do_not_fit_in_brackets_become_lines() -> None:
    text = "// a *) b\nPROGRAM P\nEND_PROGRAM"
    (unit,) = parse(text).check().units
    assert print_units([unit]) == "/// a *) b\nPROGRAM P\nEND_PROGRAM\n"
    assert parse(print_units([unit])).check().units == (unit,)
