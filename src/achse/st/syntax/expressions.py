"""Expressions: a Pratt parser, driven by how strongly each operator binds.

Source: IEC 61131-3 (2013) table 71.
"""

from collections.abc import Callable

from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import ADDRESS, LITERALS, NAME
from achse.st.syntax.cursor import DEEPEST, Cursor, Unexpected
from achse.st.syntax.tree import (
    Argument,
    ArrayInitial,
    Assign,
    Binary,
    Call,
    Dereference,
    DirectAddress,
    Expression,
    GlobalName,
    Index,
    Initial,
    Literal,
    Member,
    MemberInitial,
    Name,
    PartOf,
    Repetition,
    StructInitial,
    Super,
    This,
    TypeOperand,
    TypeSpec,
    Unary,
)

BINDING: dict[str, int] = {
    ":=": 1,
    "OR": 2,
    "OR_ELSE": 2,
    "XOR": 3,
    "AND": 4,
    "AND_THEN": 4,
    "=": 5,
    "<>": 5,
    "<": 6,
    "<=": 6,
    ">": 6,
    ">=": 6,
    "+": 7,
    "-": 7,
    "*": 8,
    "/": 8,
    "MOD": 8,
    "**": 9,
}
"""Precedence of operators (IEC 61131-3 table 71); operators of equal precedence bind from left to
right, `:=` from right to left."""
UNARY_BINDING = 10
_NO_ASSIGNMENT = 1
"""The binding above which `:=` is left to the caller."""

LONGEST = 1000
"""Most operators in a row on one level, and most steps of a path."""

_POSTFIX = frozenset((".", "[", "^", "("))
_STRINGS = ("STRING", "WSTRING")
_TYPES = frozenset(("STRING", "WSTRING", "ARRAY", "POINTER", "REFERENCE"))
_PREFIX = frozenset(("-", "+", "NOT"))


class ExpressionParser:
    """Reads expressions and initial values at a cursor; `type_spec` reads a type there."""

    def __init__(self, cursor: Cursor, type_spec: Callable[[], TypeSpec]) -> None:
        self._cursor = cursor
        self._type_spec = type_spec
        self._kinds = cursor.kinds
        self._words = cursor.words
        self._starts = cursor.starts

    def expression(self, power: int = 0) -> Expression:
        """Return an expression of operators that bind stronger than `power`. Raises
        `Unexpected`."""
        cursor = self._cursor
        kinds = self._kinds
        position = cursor.position
        kind = kinds[position]
        left: Expression
        if kind == NAME:
            left = Name(self._words[position], self._starts[position])
            cursor.position = position + 1
            if kinds[position + 1] in _POSTFIX:
                left = self._postfix(left)
        elif kind in LITERALS:
            left = Literal(kind, self._words[position], self._starts[position])
            cursor.position = position + 1
        else:
            left = self._prefix(kind)
        length = 0
        while True:
            position = cursor.position
            kind = kinds[position]
            binding = BINDING.get(kind, 0)
            if binding <= power:
                return left
            length += 1
            if length > LONGEST:
                raise Unexpected(
                    cursor.at, f"more than {LONGEST} operators in a row", Code.TOO_DEEP
                )
            cursor.position = position + 1
            if binding > _NO_ASSIGNMENT:
                right = self.expression(binding)
                left = Binary(kind, left, right, self._starts[position])
            else:
                cursor.deeper()
                left = Assign(":=", left, self.expression(), self._starts[position])
                cursor.depth -= 1

    def reference(self) -> Expression:
        """Parse an expression up to, and without, an assignment."""
        return self.expression(_NO_ASSIGNMENT)

    def _prefix(self, kind: str) -> Expression:
        cursor = self._cursor
        at = cursor.at
        if kind in _PREFIX:
            cursor.deeper()
            cursor.position += 1
            operand = self.expression(UNARY_BINDING)
            cursor.depth -= 1
            return Unary(kind, operand, at)
        if kind == "(":
            cursor.deeper()
            cursor.position += 1
            inner = self.expression()
            cursor.expect(")")
            cursor.depth -= 1
            # `(a + b).c` is none, but `(pointer + 8)^` is.
            return self._postfix(inner) if self._kinds[cursor.position] == "^" else inner
        if kind == "THIS" or kind == "SUPER":
            cursor.position += 1
            return self._postfix(This(at) if kind == "THIS" else Super(at))
        if kind == ".":
            cursor.position += 1
            return self._postfix(GlobalName(cursor.name().name, at))
        if kind in _STRINGS and self._kinds[cursor.position + 1] == ".":
            # A unit may be called String after all: `String.Concat(…)`.
            cursor.position += 1
            return self._postfix(Name(self._words[cursor.position - 1], at))
        if kind == ADDRESS:
            cursor.position += 1
            return self._postfix(DirectAddress(self._words[cursor.position - 1], at))
        if kind in _TYPES:
            return TypeOperand(self._type_spec(), at)
        raise cursor.unexpected("an expression")

    def _postfix(self, left: Expression) -> Expression:
        cursor = self._cursor
        kinds = self._kinds
        steps = 0
        while True:
            position = cursor.position
            kind = kinds[position]
            at = self._starts[position]
            if kind == ".":
                left = self._member(left)
            elif kind == "[":
                cursor.deeper()
                cursor.position = position + 1
                indices = [self.expression()]
                while cursor.take(","):
                    indices.append(self.expression())
                cursor.expect("]", "',' or ']'")
                cursor.depth -= 1
                left = Index(left, tuple(indices), at)
            elif kind == "^":
                cursor.position = position + 1
                left = Dereference(left, at)
            elif kind == "(":
                left = Call(left, self.arguments(), at)
            else:
                return left
            steps += 1
            if steps > DEEPEST:
                raise Unexpected(at, f"a path of more than {DEEPEST} steps", Code.TOO_DEEP)

    def _member(self, left: Expression) -> Expression:
        cursor = self._cursor
        position = cursor.position + 1
        kind = self._kinds[position]
        word = self._words[position]
        at = self._starts[position]
        cursor.position = position + 1
        if kind == NAME:
            return Member(left, word, at)
        if kind == "integer" and word.isdecimal() and len(word) <= 2:
            return PartOf(left, "X", int(word), at)
        if kind == "partial":
            return PartOf(left, word[1].upper(), int(word[2:]), at)
        cursor.position = position
        raise cursor.unexpected("a name or a bit number after '.'")

    def arguments(self) -> tuple[Argument, ...]:
        """`(a, nIn := b, nOut => c)`. Raises `Unexpected`."""
        cursor = self._cursor
        cursor.expect("(")
        if cursor.take(")"):
            return ()
        cursor.deeper()
        arguments = [self._argument()]
        while cursor.take(",") and self._kinds[cursor.position] != ")":
            arguments.append(self._argument())
        cursor.expect(")", "',' or ')'")
        cursor.depth -= 1
        return tuple(arguments)

    def _argument(self) -> Argument:
        cursor = self._cursor
        position = cursor.position
        at = self._starts[position]
        if self._kinds[position] == NAME:
            sign = self._kinds[position + 1]
            if sign == NAME and cursor.setter(1) == "REF=":
                cursor.position = position + 3
                return Argument(self._words[position], self.expression(), False, at)
            if sign == ":=" or sign == "=>":
                cursor.position = position + 2
                empty = self._kinds[position + 2] in (",", ")")
                value = None if empty else self.expression()
                return Argument(self._words[position], value, sign == "=>", at)
        return Argument("", self.expression(), False, at)

    # initial values ------------------------------------------------------------------------

    def initial(self) -> Initial:
        """Return the initial value that follows `:=` in a declaration. Raises `Unexpected`."""
        cursor = self._cursor
        position = cursor.position
        if self._kinds[position] == "[":
            return self.array_initial()
        if self._is_structure(position):
            initial = self._struct_initial()
            if self._kinds[cursor.position] not in BINDING:
                return initial
            cursor.position = position  # `(a := 0) OR b` only begins like a structure
        return self.expression()

    def _is_structure(self, position: int) -> bool:
        """Return True if the next tokens are `(a :=` or `()`."""
        kinds = self._kinds
        if kinds[position] != "(":
            return False
        first = kinds[position + 1]
        if first != NAME:
            return first == ")"
        ahead = position + 2 - self._cursor.position
        return kinds[position + 2] == ":=" or self._cursor.setter(ahead) == "REF="

    def array_initial(self) -> ArrayInitial:
        """`[1, 2(0), (a := 1)]`. Raises `Unexpected`."""
        cursor = self._cursor
        at = cursor.expect("[")
        cursor.deeper()
        values: list[Initial | Repetition] = []
        while self._kinds[cursor.position] != "]":
            values.append(self.element())
            if not cursor.take(","):
                break
        cursor.expect("]", "',' or ']'")
        cursor.depth -= 1
        return ArrayInitial(tuple(values), at)

    def array_arguments(self) -> ArrayInitial:
        """`[(1, 2), (nPort := 3)]`: arguments of FB_init for each element of an array of blocks.
        Raises `Unexpected`."""
        cursor = self._cursor
        at = cursor.expect("[")
        values: list[Initial | Repetition] = []
        while self._kinds[cursor.position] != "]":
            is_one = self._kinds[cursor.position] == "("
            values.append(self._arguments_of_one() if is_one else self.element())
            if not cursor.take(","):
                break
        cursor.expect("]", "',' or ']'")
        return ArrayInitial(tuple(values), at)

    def _arguments_of_one(self) -> Initial:
        """`(1, 2)` or `(nPort := 3)`; members of the first have no names. One value in brackets is
        itself."""
        cursor = self._cursor
        if self._is_structure(cursor.position):
            return self._struct_initial()
        at = cursor.expect("(")
        cursor.deeper()
        members: list[MemberInitial] = []
        while self._kinds[cursor.position] != ")":
            start, name = cursor.at, ""
            if self._kinds[cursor.position] == NAME and self._kinds[cursor.position + 1] == ":=":
                name = cursor.name().name
                cursor.expect(":=")
            members.append(MemberInitial(name, self.initial(), start))
            if not cursor.take(","):
                break
        cursor.expect(")", "',' or ')'")
        cursor.depth -= 1
        return members[0].value if len(members) == 1 else StructInitial(tuple(members), at)

    def element(self) -> Initial | Repetition:
        """One value of an array, or several: `3(0)`, `(cLast + 1)(0)`. Raises `Unexpected`."""
        cursor = self._cursor
        value = self._count() or self.initial()
        at = cursor.at
        # A name before the bracket reads as a call; which it is shows in what the name means.
        if not (isinstance(value, Expression) and cursor.take("(")):
            return value
        values: list[Initial] = []
        cursor.deeper()
        while self._kinds[cursor.position] != ")":
            values.append(self.initial())
            if not cursor.take(","):
                break
        cursor.expect(")", "',' or ')'")
        cursor.depth -= 1
        return Repetition(value, tuple(values), at)

    def _count(self) -> Expression | None:
        """Return the name before `((a := 1))` or `([1])`, which no call takes: it counts."""
        cursor = self._cursor
        kinds = self._kinds
        last = cursor.position
        while kinds[last] == NAME and kinds[last + 1] == ".":
            last += 2
        if kinds[last] != NAME or kinds[last + 1] != "(":
            return None
        if kinds[last + 2] != "[" and not self._is_structure(last + 2):
            return None
        count: Expression = Name(self._words[cursor.position], cursor.at)
        cursor.position += 1
        while cursor.position <= last:
            count = self._member(count)
        return count

    def _struct_initial(self) -> StructInitial:
        cursor = self._cursor
        at = cursor.expect("(")
        cursor.deeper()
        members: list[MemberInitial] = []
        while self._kinds[cursor.position] != ")":
            name = cursor.name("the name of a member")
            is_reference = cursor.setter() == "REF="
            if is_reference:
                cursor.position += 2
            else:
                cursor.expect(":=")
            members.append(MemberInitial(name.name, self.initial(), name.at, is_reference))
            if not cursor.take(","):
                break
        cursor.expect(")", "',' or ')'")
        cursor.depth -= 1
        return StructInitial(tuple(members), at)
