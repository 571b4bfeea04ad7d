"""Expressions: what binds to what, paths, calls, initial values; 100 snippets."""

import pytest

from achse.st.lexis.source import Source, SourceError
from achse.st.syntax import tree
from achse.st.syntax.cursor import DEEPEST
from achse.st.syntax.expressions import LONGEST
from achse.st.syntax.parser import Parser, parse_expression


def bracketed(node: object) -> str:
    """An expression with every operator in brackets."""
    match node:
        case tree.Literal(_, text):
            return text
        case tree.Name(name):
            return name
        case tree.GlobalName(name):
            return f".{name}"
        case tree.This():
            return "THIS"
        case tree.Super():
            return "SUPER"
        case tree.Member(of, name):
            return f"{bracketed(of)}.{name}"
        case tree.PartOf(of, width, number):
            return f"{bracketed(of)}.%{width}{number}"
        case tree.Index(of, indices):
            return f"{bracketed(of)}[{','.join(map(bracketed, indices))}]"
        case tree.Dereference(of):
            return f"{bracketed(of)}^"
        case tree.Argument(name, value, is_output):
            inner = "" if value is None else bracketed(value)
            return f"{name}{'=>' if is_output else ':='}{inner}" if name else inner
        case tree.Call(of, arguments):
            return f"{bracketed(of)}({','.join(map(bracketed, arguments))})"
        case tree.Unary(operator, operand):
            return f"({operator} {bracketed(operand)})"
        case tree.Binary(operator, left, right) | tree.Assign(operator, left, right):
            return f"({bracketed(left)} {operator} {bracketed(right)})"
        case tree.TypeOperand(type):
            return f"<{type.__class__.__name__}>"
        case tree.ArrayInitial(values):
            return f"[{','.join(map(bracketed, values))}]"
        case tree.Repetition(count, values):
            return f"{bracketed(count)}*{{{','.join(map(bracketed, values))}}}"
        case tree.StructInitial(members):
            return f"{{{','.join(f'{m.name}:={bracketed(m.value)}' for m in members)}}}"
    raise AssertionError(node)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1", "1"),
        ("a", "a"),
        (".a", ".a"),
        ("(a)", "a"),
        ("((a))", "a"),
        ("a + b", "(a + b)"),
        ("a - b - c", "((a - b) - c)"),
        ("a - (b - c)", "(a - (b - c))"),
        ("a / b * c", "((a / b) * c)"),
        ("a + b * c", "(a + (b * c))"),
        ("a * b + c", "((a * b) + c)"),
        ("a MOD b + c", "((a MOD b) + c)"),
        ("a ** b ** c", "((a ** b) ** c)"),
        ("a * b ** c", "(a * (b ** c))"),
        ("-a ** b", "((- a) ** b)"),
        ("-a * b", "((- a) * b)"),
        ("- - a", "(- (- a))"),
        ("+a - -b", "((+ a) - (- b))"),
        ("a < b", "(a < b)"),
        ("a < b = c", "((a < b) = c)"),
        ("a = b <> c", "((a = b) <> c)"),
        ("a + 1 >= b - 1", "((a + 1) >= (b - 1))"),
        ("a <= b", "(a <= b)"),
        ("a > b", "(a > b)"),
        ("NOT a AND b", "((NOT a) AND b)"),
        ("NOT a = b", "((NOT a) = b)"),
        ("NOT (a = b)", "(NOT (a = b))"),
        ("NOT NOT a", "(NOT (NOT a))"),
        ("a AND b OR c", "((a AND b) OR c)"),
        ("a OR b AND c", "(a OR (b AND c))"),
        ("a XOR b OR c", "((a XOR b) OR c)"),
        ("a AND b XOR c", "((a AND b) XOR c)"),
        ("a & b", "(a AND b)"),
        ("a AND_THEN b OR_ELSE c", "((a AND_THEN b) OR_ELSE c)"),
        ("a = b AND c = d", "((a = b) AND (c = d))"),
        ("a or B And not c", "(a OR (B AND (NOT c)))"),
        ("a := b", "(a := b)"),
        ("a := b := c + 1", "(a := (b := (c + 1)))"),
        ("(a := b) = c", "((a := b) = c)"),
        ("a.b", "a.b"),
        ("a.b.c", "a.b.c"),
        ("a . b", "a.b"),
        ("a.3", "a.%X3"),
        ("a.b.31", "a.b.%X31"),
        ("a.%X7", "a.%X7"),
        ("a.%B1", "a.%B1"),
        ("a.%w0", "a.%W0"),
        ("a[1]", "a[1]"),
        ("a[1, i + 1]", "a[1,(i + 1)]"),
        ("a[1][2].x", "a[1][2].x"),
        ("a[b[c[0]]]", "a[b[c[0]]]"),
        ("p^", "p^"),
        ("p^.x^[1]", "p^.x^[1]"),
        ("(p + 8)^", "(p + 8)^"),
        ("p^ + 1", "(p^ + 1)"),
        ("THIS^.x", "THIS^.x"),
        ("SUPER^.Run(1)", "SUPER^.Run(1)"),
        ("THIS", "THIS"),
        (".gv.x", ".gv.x"),
        ("f()", "f()"),
        ("f(1)", "f(1)"),
        ("f(a, b + 1)", "f(a,(b + 1))"),
        ("f(a := 1, b => c)", "f(a:=1,b=>c)"),
        ("f(a := , b => )", "f(a:=,b=>)"),
        ("f(a := b := 2)", "f(a:=(b := 2))"),
        ("f(1,)", "f(1)"),
        ("f(g(h(1)))", "f(g(h(1)))"),
        ("fb.m(1).n(2)[3]", "fb.m(1).n(2)[3]"),
        ("f(1)^.x", "f(1)^.x"),
        ("TO_INT(x) * 2", "(TO_INT(x) * 2)"),
        ("ADR(a[1])", "ADR(a[1])"),
        ("SIZEOF(STRING(80))", "SIZEOF(<StringOf>)"),
        ("__NEW(POINTER TO INT, 5)", "__NEW(<PointerTo>,5)"),
        ("String.Concat(a)", "String.Concat(a)"),
        ("GVL.E_State.Idle", "GVL.E_State.Idle"),
        ("E_State#Idle", "E_State#Idle"),
        ("T#1s + T#5ms", "(T#1s + T#5ms)"),
        ("T#5s-T#3s", "(T#5s - T#3s)"),
        ("16#FF AND NOT 2#1010_1010", "(16#FF AND (NOT 2#1010_1010))"),
        ("'it$'s' = sText", "('it$'s' = sText)"),
        ("1.5E-3 + 2", "(1.5E-3 + 2)"),
        ("5-3", "(5 - 3)"),
        ("a-1", "(a - 1)"),
        ("TRUE", "TRUE"),
        ("Step = GET", "(Step = GET)"),
    ],
)
def test_operators_bind_as_the_standard_says(text: str, expected: str) -> None:
    assert bracketed(parse_expression(text)) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5", "5"),
        ("[1, 2]", "[1,2]"),
        ("[]", "[]"),
        ("[1, 3(0), 2]", "[1,3*{0},2]"),
        ("[2(1, 2)]", "[2*{1,2}]"),
        ("[[1, 2], [3]]", "[[1,2],[3]]"),
        ("[4()]", "[4*{}]"),
        ("[cCount(0)]", "[cCount(0)]"),
        ("[(cCount + 1)(0), 2]", "[(cCount + 1)*{0},2]"),
        ("[(a + 1) * 2]", "[((a + 1) * 2)]"),
        ("[GVL.cCount((a := 1, b := 2), 3)]", "[GVL.cCount*{{a:=1,b:=2},3}]"),
        ("[cCount([1, 2]), cLast()]", "[cCount*{[1,2]},cLast()]"),
        ("(a := 1, b := 2)", "{a:=1,b:=2}"),
        ("(a := [1, 2], b := (c := 3))", "{a:=[1,2],b:={c:=3}}"),
        ("[(a := 1), 2((a := 2))]", "[{a:=1},2*{{a:=2}}]"),
        ("(a + 1) * 2", "((a + 1) * 2)"),
        ("()", "{}"),
        ("E_X.A", "E_X.A"),
    ],
)
def test_initial_values(text: str, expected: str) -> None:
    parser = Parser(Source(text))
    expression = parser.attempt(parser.expressions.initial)
    assert parser.faults == []
    assert bracketed(expression) == expected


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "expected an expression, got the end"),
        ("1 +", 4, "expected an expression, got the end"),
        ("* 2", 1, "expected an expression, got '*'"),
        ("a + * b", 5, "expected an expression, got '*'"),
        ("(a", 3, "expected ')', got the end"),
        ("a)", 2, "expected the end, got ')'"),
        ("a b", 3, "expected the end, got 'b'"),
        ("a[1", 4, "expected ',' or ']', got the end"),
        ("a[]", 3, "expected an expression, got ']'"),
        ("f(1 2)", 5, "expected ',' or ')', got '2'"),
        ("f(,)", 3, "expected an expression, got ','"),
        ("a.", 3, "expected a name or a bit number after '.', got the end"),
        ("a.IF", 3, "expected a name or a bit number after '.', got 'IF'"),
        ("a.123", 3, "expected a name or a bit number after '.', got '123'"),
        ("NOT", 4, "expected an expression, got the end"),
        ("IF", 1, "expected an expression, got 'IF'"),
        ("1 .. 2", 3, "expected the end, got '..'"),
        ("2#12", 1, "a number takes digits of base 2 after #, got '2#12'"),
        ("16#", 1, "a number takes digits of base 16 after #, got '16#'"),
        ("7#1", 1, "a number takes the base 2, 8, 10 or 16 before #, got '7#1'"),
        ("1_0_", 1, "a number takes digits, like 10, 16#FF or 1.5E3, got '1_0_'"),
        ("12ab", 1, "a number takes digits, like 10, 16#FF or 1.5E3, got '12ab'"),
        ("INT#40000", 1, "INT takes an integer in -32768..32767, got 40000"),
        ("BOOL#2", 1, "BOOL takes TRUE or FALSE, got 'BOOL#2'"),
        ("T#5x", 1, "TIME takes"),
        ("D#2024-13-01", 1, "DATE takes"),
        ("TOD#25:00", 1, "TOD takes"),
        ("'abc", 1, "a string literal takes a closing '"),
        ("a ? b", 3, "expected Structured Text, got '?'"),
        ("%ZZ1", 1, "expected an address like %IX0.3, %MD4 or %Q*"),
    ],
)
def test_faults_say_where_and_what(text: str, column: int, message: str) -> None:
    with pytest.raises(SourceError) as caught:
        parse_expression(text)
    first = caught.value.faults[0]
    assert (first.location.line, first.location.column) == (1, column)
    assert first.message.startswith(message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2", "expected ',' or ']', got the end"),
        ("[1 2]", "expected ',' or ']', got '2'"),
        ("[2(3(0))]", "expected ',' or ')', got '('"),
        ("(a := 1", "expected ',' or ')', got the end"),
        ("(a := 1, 2)", "expected the name of a member, got '2'"),
        ("(a := 1, b)", "expected ':=', got ')'"),
        ("(a := )", "expected an expression, got ')'"),
    ],
)
def test_faults_of_initial_values(text: str, message: str) -> None:
    parser = Parser(Source(text))
    assert parser.attempt(parser.expressions.initial) is None
    assert parser.faults[0].message == message


@pytest.mark.parametrize("opening", ["(", "-", "NOT ", "f(", "a[", "x := ", "[", "(a := "])
def test_deep_nesting_is_a_fault(opening: str) -> None:
    for depth in (DEEPEST + 1, 20_000):
        parser = Parser(Source(opening * depth + "1"))
        assert parser.attempt(parser.expressions.initial) is None
        assert f"deeper than {DEEPEST}" in parser.faults[0].message


def test_nesting_up_to_the_limit_is_read() -> None:
    depth = DEEPEST - 1
    expression = parse_expression("(" * depth + "1" + ")" * depth)
    assert expression == tree.Literal("integer", "1")


def test_long_chains_are_read_up_to_a_limit() -> None:
    assert parse_expression(" + ".join(["1"] * (LONGEST + 1)))
    with pytest.raises(SourceError, match="operators in a row"):
        parse_expression(" + ".join(["1"] * (LONGEST + 2)))
    with pytest.raises(SourceError, match="a path of more than"):
        parse_expression("a" + ".b" * (DEEPEST + 1))


def test_every_node_knows_its_place() -> None:
    text = "a.b[i] + f(x := 2)"
    expression = parse_expression(text)
    assert isinstance(expression, tree.Binary)
    assert expression.at == text.index("+")
    assert isinstance(expression.left, tree.Index)
    assert expression.left.at == text.index("[")
    assert isinstance(expression.left.of, tree.Member)
    assert expression.left.of.at == text.index("b")
    assert isinstance(expression.right, tree.Call)
    assert expression.right.arguments[0].at == text.index("x")


def test_an_assignment_in_brackets_may_begin_an_initial_value() -> None:
    parser = Parser(Source("(a := 0) OR b"))
    expression = parser.attempt(parser.expressions.initial)
    assert isinstance(expression, tree.Binary)
    assert isinstance(expression.left, tree.Assign)
    parser = Parser(Source("(a := 0)"))
    assert isinstance(parser.attempt(parser.expressions.initial), tree.StructInitial)
