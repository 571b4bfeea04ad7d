"""Statements: bodies of programs, function blocks, functions, methods and actions.

Source: IEC 61131-3 (2013) table 72.
"""

from collections.abc import Callable, Iterator

from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import END
from achse.st.lexis.words import BLOCK_WORDS, INNER_ENDS, STATEMENT_WORDS
from achse.st.syntax.cursor import Cursor, Unexpected
from achse.st.syntax.expressions import ExpressionParser
from achse.st.syntax.tree import (
    Assign,
    Branch,
    Call,
    Case,
    Choice,
    Continue,
    Dereference,
    Exit,
    Expression,
    For,
    GlobalName,
    If,
    Index,
    Jump,
    Label,
    Member,
    Name,
    Range,
    RepeatUntil,
    Return,
    Statement,
    Statements,
    Try,
    While,
)

_ENDS = BLOCK_WORDS | INNER_ENDS | {"END_STRUCT", "END_UNION", END}
"""Tokens that start no statement, so that a list of statements ends before them."""
_RESUME = STATEMENT_WORDS | INNER_ENDS
_HEAD_ENDS = _ENDS | _RESUME | {";", "THEN", "DO", "OF"}
_NO_LABEL = _ENDS | STATEMENT_WORDS | {";"}
_LABEL_ENDS = _ENDS | STATEMENT_WORDS | {":", ";"}
_LABELS = frozenset((":", ",", "..", ":="))
_OPENING = frozenset("([")
_CLOSING = frozenset(")]")
_CALLABLE = (Call, Name, GlobalName, Member, Dereference, Index)


class StatementParser:
    """Reads statements at a cursor. A fault costs the statement it is in; the rest is read."""

    def __init__(self, cursor: Cursor, expressions: ExpressionParser) -> None:
        self._cursor = cursor
        self._expressions = expressions
        self._kinds = cursor.kinds
        self._words = cursor.words
        self._starts = cursor.starts

    def statements(self, in_case: bool = False) -> Statements:
        """Parse all statements up to a word that ends them; in a CASE also up to a label."""
        cursor = self._cursor
        kinds = self._kinds
        statements: list[Statement] = []
        while True:
            position = cursor.position
            kind = kinds[position]
            if kind in _ENDS or (in_case and self._at_label()):
                return tuple(statements)
            if kind == ";":
                cursor.position = position + 1
                continue
            depth = cursor.depth
            try:
                block = _BLOCKS.get(kind)
                statements.append(self._simple() if block is None else block(self))
            except Unexpected as fault:
                cursor.report(fault)
                cursor.depth = depth
                cursor.skip_to(_RESUME, position)

    def _simple(self) -> Statement:
        """Parse an assignment, a call or a label."""
        cursor = self._cursor
        position = cursor.position
        target = self._expressions.reference()
        kind = self._kinds[cursor.position]
        if kind == ":=":
            at = self._starts[cursor.position]
            cursor.position += 1
            statement: Statement = Assign(":=", target, self._assigned(), at)
        elif kind == ";" and isinstance(target, _CALLABLE):
            cursor.position += 1
            return target
        elif kind == ":" and isinstance(target, Name):
            cursor.position += 1
            return Label(target.name, target.at)
        elif (sign := cursor.setter()) is not None:
            at = cursor.at
            cursor.position += 2
            statement = Assign(sign, target, self._assigned(), at)
        elif isinstance(target, _CALLABLE):
            if not isinstance(target, Call) and kind in ("=", "name", "integer"):
                raise cursor.unexpected("':='")
            statement = target
        else:
            raise Unexpected(
                self._starts[position],
                "expected an assignment or a call, got an expression",
                Code.NOT_A_STATEMENT,
            )
        cursor.expect_end(";")
        return statement

    def _assigned(self) -> Expression:
        """Parse the right-hand side of an assignment; `b S= c` in it continues the chain: `a := b
        S= c`."""
        cursor = self._cursor
        value = self._expressions.expression()
        if self._kinds[cursor.position] == ";" or (sign := cursor.setter()) is None:
            return value
        at = cursor.at
        cursor.position += 2
        cursor.deeper()
        rest = self._assigned()
        cursor.depth -= 1
        return _with_last(value, lambda last: Assign(sign, last, rest, at))

    def _at_label(self) -> bool:
        """Return True if the next token begins the label of a CASE rather than a statement."""
        kinds = self._kinds
        position = self._cursor.position
        inside = 0
        while (kind := kinds[position]) not in _NO_LABEL:
            if kind in _OPENING:
                inside += 1
            elif kind in _CLOSING:
                inside -= 1
            elif inside == 0 and kind in _LABELS:
                return kind != ":="
            position += 1
        return False

    # blocks --------------------------------------------------------------------------------

    def _body(self, in_case: bool = False) -> Statements:
        self._cursor.deeper()
        body = self.statements(in_case)
        self._cursor.depth -= 1
        return body

    def _close(self, word: str) -> None:
        """Skip END_IF and the like; one that is missing is reported, and reading goes on."""
        cursor = self._cursor
        if cursor.take(word):
            cursor.take(";")
        else:
            cursor.report(cursor.unexpected(word))

    def _condition(self) -> tuple[Expression, ...]:
        return (self._expressions.expression(),)

    def _head(
        self, word: str, read: Callable[[], tuple[Expression, ...]], count: int = 1
    ) -> tuple[Expression, ...]:
        """Parse the head before THEN, OF or DO. If the head is at fault the body is still read, so
        that its END is not a second fault."""
        cursor = self._cursor
        depth, start = cursor.depth, cursor.position
        try:
            head = read()
            cursor.expect(word, word)
        except Unexpected as fault:
            cursor.report(fault)
            cursor.depth = depth
            while self._kinds[cursor.position] not in _HEAD_ENDS:
                cursor.position += 1
            if not cursor.take(word):
                cursor.take(";")
            return (Name("", self._starts[start]),) * count
        return head

    def _if(self) -> If:
        cursor = self._cursor
        at = cursor.at
        branches: list[Branch] = []
        while self._kinds[cursor.position] in ("IF", "ELSIF"):
            if branches and self._kinds[cursor.position] == "IF":
                break
            place = cursor.at
            cursor.position += 1
            (condition,) = self._head("THEN", self._condition)
            branches.append(Branch(condition, self._body(), place))
        otherwise = self._body() if cursor.take("ELSE") else ()
        self._close("END_IF")
        return If(tuple(branches), otherwise, at)

    def _case(self) -> Case:
        cursor = self._cursor
        at = cursor.expect("CASE")
        (selector,) = self._head("OF", self._condition)
        choices = list(self._choices())
        has_else = bool(cursor.take("ELSE"))
        otherwise = self._body(in_case=True) if has_else else ()
        choices += self._choices()  # ELSE need not be the last branch (decision 0239)
        self._close("END_CASE")
        return Case(selector, tuple(choices), otherwise, at, has_else and not otherwise)

    def _choices(self) -> Iterator[Choice]:
        """Parse branches with labels, as far as there are any."""
        cursor = self._cursor
        while (kind := self._kinds[cursor.position]) not in _ENDS:
            place = cursor.at
            if kind == ";":
                cursor.position += 1
                continue
            labels = self._labels()
            yield Choice(labels, self._body(in_case=True), place)

    def _labels(self) -> tuple[Expression | Range, ...]:
        """Parse the labels before the colon. If they are at fault the choice is still read."""
        cursor = self._cursor
        depth, start = cursor.depth, cursor.position
        try:
            labels = [self._label()]
            while cursor.take(","):
                labels.append(self._label())
            cursor.expect(":", "',' or ':' after the label")
        except Unexpected as fault:
            cursor.report(fault)
            cursor.depth = depth
            while self._kinds[cursor.position] not in _LABEL_ENDS:
                cursor.position += 1
            if not cursor.take(":"):
                cursor.take(";")
            return (Name("", self._starts[start]),)
        return tuple(labels)

    def _label(self) -> Expression | Range:
        label = self._expressions.reference()
        if self._kinds[self._cursor.position] != "..":
            return label
        at = self._cursor.expect("..")
        return Range(label, self._expressions.reference(), at)

    def _for(self) -> For:
        at = self._cursor.expect("FOR")
        variable, first, last, *step = self._head("DO", self._range, 3)
        body = self._body()
        self._close("END_FOR")
        return For(variable, first, last, step[0] if step else None, body, at)

    def _range(self) -> tuple[Expression, ...]:
        cursor = self._cursor
        variable = self._expressions.reference()
        cursor.expect(":=")
        first = self._expressions.expression()
        cursor.expect("TO", "TO")
        last = self._expressions.expression()
        if cursor.take("BY"):
            return variable, first, last, self._expressions.expression()
        if self._kinds[cursor.position] != "DO":
            raise cursor.unexpected("BY or DO")
        return variable, first, last

    def _while(self) -> While:
        at = self._cursor.expect("WHILE")
        (condition,) = self._head("DO", self._condition)
        body = self._body()
        self._close("END_WHILE")
        return While(condition, body, at)

    def _repeat(self) -> RepeatUntil:
        cursor = self._cursor
        at = cursor.expect("REPEAT")
        body = self._body()
        depth = cursor.depth
        condition: Expression = Name("", at)
        try:
            cursor.expect("UNTIL", "UNTIL")
            condition = self._expressions.expression()
            cursor.take(";")
        except Unexpected as fault:
            cursor.report(fault)
            cursor.depth = depth
            while self._kinds[cursor.position] not in _ENDS:
                cursor.position += 1
            cursor.take("END_REPEAT")
            return RepeatUntil(body, condition, at)
        self._close("END_REPEAT")
        return RepeatUntil(body, condition, at)

    def _try(self) -> Try:
        cursor = self._cursor
        at = cursor.expect("__TRY")
        body = self._body()
        exception: Expression | None = None
        handler: Statements = ()
        if cursor.take("__CATCH"):
            if cursor.take("("):
                exception = self._expressions.expression()
                cursor.expect(")")
            handler = self._body()
        final = self._body() if cursor.take("__FINALLY") else ()
        self._close("__ENDTRY")
        return Try(body, exception, handler, final, at)

    def _exit(self) -> Statement:
        return self._leaving(Exit(self._cursor.expect("EXIT")))

    def _continue(self) -> Statement:
        return self._leaving(Continue(self._cursor.expect("CONTINUE")))

    def _return(self) -> Statement:
        return self._leaving(Return(self._cursor.expect("RETURN")))

    def _leaving(self, statement: Exit | Continue | Return) -> Statement:
        """`RETURN;`, or with a condition `RETURN(bDone);`, which is an IF around it."""
        cursor = self._cursor
        if self._kinds[cursor.position] != "(":
            cursor.expect_end(";")
            return statement
        condition = self._expressions.expression()
        cursor.expect_end(";")
        return If((Branch(condition, (statement,), statement.at),), (), statement.at)

    def _jump(self) -> Jump:
        cursor = self._cursor
        at = cursor.expect("JMP")
        label = cursor.name("the name of a label")
        cursor.expect_end(";")
        return Jump(label.name, at)


def _with_last(tree: Expression, replacement: Callable[[Expression], Expression]) -> Expression:
    """Return a chain `a := b := c` with another expression in place of its last one."""
    if isinstance(tree, Assign):
        return Assign(tree.operator, tree.target, _with_last(tree.value, replacement), tree.at)
    return replacement(tree)


_BLOCKS: dict[str, Callable[[StatementParser], Statement]] = {
    "IF": StatementParser._if,
    "CASE": StatementParser._case,
    "FOR": StatementParser._for,
    "WHILE": StatementParser._while,
    "REPEAT": StatementParser._repeat,
    "__TRY": StatementParser._try,
    "EXIT": StatementParser._exit,
    "CONTINUE": StatementParser._continue,
    "RETURN": StatementParser._return,
    "JMP": StatementParser._jump,
}
