"""Statements: bodies of programs, function blocks, functions, methods and actions.

Source: IEC 61131-3 (2013) table 72.
"""

from collections.abc import Callable

from achse.st.cursor import Unexpected
from achse.st.expressions import ExpressionParser
from achse.st.lexer import END, NAME
from achse.st.tree import (
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
from achse.st.words import BLOCK_WORDS, INNER_ENDS, STATEMENT_WORDS

__all__ = ["StatementParser"]

_ENDS = BLOCK_WORDS | INNER_ENDS | {"END_STRUCT", "END_UNION", END}
"""What no statement starts with, so that a list of statements ends before it."""
_RESUME = STATEMENT_WORDS | INNER_ENDS
_HEAD_ENDS = _ENDS | _RESUME | {";", "THEN", "DO", "OF"}
_NO_LABEL = _ENDS | STATEMENT_WORDS | {";"}
_LABEL_ENDS = _ENDS | STATEMENT_WORDS | {":", ";"}
_LABELS = frozenset((":", ",", "..", ":="))
_OPENING = frozenset("([")
_CLOSING = frozenset(")]")
_CALLABLE = (Call, Name, GlobalName, Member, Dereference, Index)
_SETTERS = frozenset(("S", "R", "REF"))


class StatementParser(ExpressionParser):
    """Reads statements. A fault costs the statement it is in; reading goes on after it."""

    def statements(self, in_case: bool = False) -> Statements:
        """All statements up to a word that ends them; in a CASE also up to a label."""
        kinds = self.kinds
        found: list[Statement] = []
        while True:
            position = self.position
            kind = kinds[position]
            if kind in _ENDS or (in_case and self._at_label()):
                return tuple(found)
            if kind == ";":
                self.position = position + 1
                continue
            depth = self.depth
            try:
                block = _BLOCKS.get(kind)
                found.append(self._simple() if block is None else block(self))
            except Unexpected as fault:
                self.report(fault)
                self.depth = depth
                self.skip_to(_RESUME, position)

    def _simple(self) -> Statement:
        """An assignment, a call or a label."""
        position = self.position
        target = self.reference()
        kind = self.kinds[self.position]
        if kind == ":=":
            at = self.starts[self.position]
            self.position += 1
            statement: Statement = Assign(":=", target, self._assigned(), at)
        elif kind == ";" and isinstance(target, _CALLABLE):
            self.position += 1
            return target
        elif kind == ":" and isinstance(target, Name):
            self.position += 1
            return Label(target.name, target.at)
        elif (sign := self.setter()) is not None:
            at = self.at
            self.position += 2
            statement = Assign(sign, target, self._assigned(), at)
        elif isinstance(target, _CALLABLE):
            if not isinstance(target, Call) and kind in ("=", "name", "integer"):
                raise self.unexpected("':='")
            statement = target
        else:
            raise Unexpected(
                self.starts[position], "expected an assignment or a call, got an expression"
            )
        self.expect_end(";")
        return statement

    def _assigned(self) -> Expression:
        """What is assigned; `b S= c` in it goes on with the chain: `a := b S= c`."""
        value = self.expression()
        sign = self.setter()
        if sign is None:
            return value
        at = self.at
        self.position += 2
        self.deeper()
        rest = self._assigned()
        self.depth -= 1
        return _with_last(value, lambda last: Assign(sign, last, rest, at))

    def setter(self) -> str | None:
        """`S=`, `R=` or `REF=` if one comes next: a name and a sign that touch each other."""
        position = self.position
        kinds = self.kinds
        if kinds[position] != NAME or kinds[position + 1] != "=":
            return None
        word = self.words[position].upper()
        touching = self.starts[position] + len(word) == self.starts[position + 1]
        return f"{word}=" if touching and word in _SETTERS else None

    def _at_label(self) -> bool:
        """Whether the next token begins the label of a CASE rather than a statement."""
        kinds = self.kinds
        position = self.position
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
        self.deeper()
        body = self.statements(in_case)
        self.depth -= 1
        return body

    def _close(self, word: str) -> None:
        """Go past END_IF and the like; one that is missing is reported, and reading goes on."""
        if self.take(word):
            self.take(";")
        else:
            self.report(self.unexpected(word))

    def _condition(self) -> tuple[Expression, ...]:
        return (self.expression(),)

    def _head(
        self, word: str, read: Callable[[], tuple[Expression, ...]], count: int = 1
    ) -> tuple[Expression, ...]:
        """What stands before THEN, OF or DO. If that is at fault the body is still read, so that
        its END is no second fault."""
        depth, start = self.depth, self.position
        try:
            found = read()
            self.expect(word, word)
        except Unexpected as fault:
            self.report(fault)
            self.depth = depth
            while self.kinds[self.position] not in _HEAD_ENDS:
                self.position += 1
            if not self.take(word):
                self.take(";")
            return (Name("", self.starts[start]),) * count
        return found

    def _if(self) -> If:
        at = self.at
        branches: list[Branch] = []
        while self.kinds[self.position] in ("IF", "ELSIF"):
            if branches and self.kinds[self.position] == "IF":
                break
            place = self.at
            self.position += 1
            (condition,) = self._head("THEN", self._condition)
            branches.append(Branch(condition, self._body(), place))
        otherwise = self._body() if self.take("ELSE") else ()
        self._close("END_IF")
        return If(tuple(branches), otherwise, at)

    def _case(self) -> Case:
        at = self.expect("CASE")
        (selector,) = self._head("OF", self._condition)
        choices = []
        while (kind := self.kinds[self.position]) not in _ENDS:
            place = self.at
            if kind == ";":
                self.position += 1
                continue
            labels = self._labels()
            choices.append(Choice(labels, self._body(in_case=True), place))
        otherwise = self._body() if self.take("ELSE") else ()
        self._close("END_CASE")
        return Case(selector, tuple(choices), otherwise, at)

    def _labels(self) -> tuple[Expression | Range, ...]:
        """What stands before the colon. If that is at fault the choice is still read."""
        depth, start = self.depth, self.position
        try:
            labels = [self._label()]
            while self.take(","):
                labels.append(self._label())
            self.expect(":", "',' or ':' after the label")
        except Unexpected as fault:
            self.report(fault)
            self.depth = depth
            while self.kinds[self.position] not in _LABEL_ENDS:
                self.position += 1
            if not self.take(":"):
                self.take(";")
            return (Name("", self.starts[start]),)
        return tuple(labels)

    def _label(self) -> Expression | Range:
        label = self.reference()
        if self.kinds[self.position] != "..":
            return label
        at = self.expect("..")
        return Range(label, self.reference(), at)

    def _for(self) -> For:
        at = self.expect("FOR")
        variable, first, last, *step = self._head("DO", self._range, 3)
        body = self._body()
        self._close("END_FOR")
        return For(variable, first, last, step[0] if step else None, body, at)

    def _range(self) -> tuple[Expression, ...]:
        variable = self.reference()
        self.expect(":=")
        first = self.expression()
        self.expect("TO", "TO")
        last = self.expression()
        if self.take("BY"):
            return variable, first, last, self.expression()
        if self.kinds[self.position] != "DO":
            raise self.unexpected("BY or DO")
        return variable, first, last

    def _while(self) -> While:
        at = self.expect("WHILE")
        (condition,) = self._head("DO", self._condition)
        body = self._body()
        self._close("END_WHILE")
        return While(condition, body, at)

    def _repeat(self) -> RepeatUntil:
        at = self.expect("REPEAT")
        body = self._body()
        depth = self.depth
        condition: Expression = Name("", at)
        try:
            self.expect("UNTIL", "UNTIL")
            condition = self.expression()
            self.take(";")
        except Unexpected as fault:
            self.report(fault)
            self.depth = depth
            while self.kinds[self.position] not in _ENDS:
                self.position += 1
            self.take("END_REPEAT")
            return RepeatUntil(body, condition, at)
        self._close("END_REPEAT")
        return RepeatUntil(body, condition, at)

    def _try(self) -> Try:
        at = self.expect("__TRY")
        body = self._body()
        exception: Expression | None = None
        handler: Statements = ()
        if self.take("__CATCH"):
            if self.take("("):
                exception = self.expression()
                self.expect(")")
            handler = self._body()
        final = self._body() if self.take("__FINALLY") else ()
        self._close("__ENDTRY")
        return Try(body, exception, handler, final, at)

    def _exit(self) -> Statement:
        return self._leaving(Exit(self.expect("EXIT")))

    def _continue(self) -> Statement:
        return self._leaving(Continue(self.expect("CONTINUE")))

    def _return(self) -> Statement:
        return self._leaving(Return(self.expect("RETURN")))

    def _leaving(self, statement: Exit | Continue | Return) -> Statement:
        """`RETURN;`, or with a condition `RETURN(bDone);`, which is an IF around it."""
        if self.kinds[self.position] != "(":
            self.expect_end(";")
            return statement
        condition = self.expression()
        self.expect_end(";")
        return If((Branch(condition, (statement,), statement.at),), (), statement.at)

    def _jump(self) -> Jump:
        at = self.expect("JMP")
        label = self.name("the name of a label")
        self.expect_end(";")
        return Jump(label.name, at)


def _with_last(tree: Expression, made: Callable[[Expression], Expression]) -> Expression:
    """A chain `a := b := c` with another expression in place of its last one."""
    if isinstance(tree, Assign):
        return Assign(tree.operator, tree.target, _with_last(tree.value, made), tree.at)
    return made(tree)


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
