"""Expressions: a Pratt parser, driven by how strongly each operator binds.

Source: IEC 61131-3 (2013) table 71.
"""

from achse.st.cursor import DEEPEST, Cursor, Unexpected
from achse.st.lexer import ADDRESS, LITERALS, NAME
from achse.st.tree import (
    Address,
    Argument,
    ArrayInitial,
    Assign,
    Binary,
    Call,
    Dereference,
    Expression,
    GlobalName,
    Index,
    Initial,
    Literal,
    Member,
    MemberInitial,
    Name,
    PartOf,
    Repeated,
    StructInitial,
    Super,
    This,
    TypeOperand,
    TypeSpec,
    Unary,
)

__all__ = ["BINDING", "LONGEST", "UNARY_BINDING", "ExpressionParser"]

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
"""How strongly operators bind (IEC 61131-3 table 71); equal ones from left to right, `:=` from
right to left."""
UNARY_BINDING = 10
_NO_ASSIGNMENT = 1
"""The binding above which `:=` is left to the caller."""

LONGEST = 1000
"""How many operators may follow each other on one level, and how many steps a path has."""

_POSTFIX = frozenset((".", "[", "^", "("))
_STRINGS = ("STRING", "WSTRING")
_TYPES = frozenset(("STRING", "WSTRING", "ARRAY", "POINTER", "REFERENCE"))
_PREFIX = frozenset(("-", "+", "NOT"))


class ExpressionParser(Cursor):
    """Reads expressions and initial values."""

    def expression(self, power: int = 0) -> Expression:
        """An expression of operators that bind stronger than `power`. Raises `Unexpected`."""
        kinds = self.kinds
        position = self.position
        kind = kinds[position]
        left: Expression
        if kind == NAME:
            left = Name(self.words[position], self.starts[position])
            self.position = position + 1
            if kinds[position + 1] in _POSTFIX:
                left = self._postfix(left)
        elif kind in LITERALS:
            left = Literal(kind, self.words[position], self.starts[position])
            self.position = position + 1
        else:
            left = self._prefix(kind)
        length = 0
        while True:
            position = self.position
            kind = kinds[position]
            binding = BINDING.get(kind, 0)
            if binding <= power:
                return left
            length += 1
            if length > LONGEST:
                raise Unexpected(self.at, f"more than {LONGEST} operators in a row")
            self.position = position + 1
            if binding > _NO_ASSIGNMENT:
                right = self.expression(binding)
                left = Binary(kind, left, right, self.starts[position])
            else:
                self.deeper()
                left = Assign(":=", left, self.expression(), self.starts[position])
                self.depth -= 1

    def reference(self) -> Expression:
        """An expression up to, and without, an assignment."""
        return self.expression(_NO_ASSIGNMENT)

    def _prefix(self, kind: str) -> Expression:
        at = self.at
        if kind in _PREFIX:
            self.deeper()
            self.position += 1
            operand = self.expression(UNARY_BINDING)
            self.depth -= 1
            return Unary(kind, operand, at)
        if kind == "(":
            self.deeper()
            self.position += 1
            inner = self.expression()
            self.expect(")")
            self.depth -= 1
            # `(a + b).c` is none, but `(pointer + 8)^` is.
            return self._postfix(inner) if self.kinds[self.position] == "^" else inner
        if kind == "THIS" or kind == "SUPER":
            self.position += 1
            return self._postfix(This(at) if kind == "THIS" else Super(at))
        if kind == ".":
            self.position += 1
            return self._postfix(GlobalName(self.name().name, at))
        if kind in _STRINGS and self.kinds[self.position + 1] == ".":
            # A unit may be called String after all: `String.Concat(…)`.
            self.position += 1
            return self._postfix(Name(self.words[self.position - 1], at))
        if kind == ADDRESS:
            self.position += 1
            return self._postfix(Address(self.words[self.position - 1], at))
        if kind in _TYPES:
            return TypeOperand(self.type_spec(), at)
        raise self.unexpected("an expression")

    def type_spec(self) -> TypeSpec:
        """A type; known one floor up."""
        raise NotImplementedError

    def _postfix(self, left: Expression) -> Expression:
        kinds = self.kinds
        steps = 0
        while True:
            position = self.position
            kind = kinds[position]
            at = self.starts[position]
            if kind == ".":
                left = self._member(left)
            elif kind == "[":
                self.deeper()
                self.position = position + 1
                indices = [self.expression()]
                while self.take(","):
                    indices.append(self.expression())
                self.expect("]", "',' or ']'")
                self.depth -= 1
                left = Index(left, tuple(indices), at)
            elif kind == "^":
                self.position = position + 1
                left = Dereference(left, at)
            elif kind == "(":
                left = Call(left, self.arguments(), at)
            else:
                return left
            steps += 1
            if steps > DEEPEST:
                raise Unexpected(at, f"a path of more than {DEEPEST} steps")

    def _member(self, left: Expression) -> Expression:
        position = self.position + 1
        kind = self.kinds[position]
        word = self.words[position]
        at = self.starts[position]
        self.position = position + 1
        if kind == NAME:
            return Member(left, word, at)
        if kind == "integer" and word.isdecimal() and len(word) <= 2:
            return PartOf(left, "X", int(word), at)
        if kind == "partial":
            return PartOf(left, word[1].upper(), int(word[2:]), at)
        self.position = position
        raise self.unexpected("a name or a bit number after '.'")

    def arguments(self) -> tuple[Argument, ...]:
        """`(a, nIn := b, nOut => c)`. Raises `Unexpected`."""
        self.expect("(")
        if self.take(")"):
            return ()
        self.deeper()
        arguments = [self._argument()]
        while self.take(",") and self.kinds[self.position] != ")":
            arguments.append(self._argument())
        self.expect(")", "',' or ')'")
        self.depth -= 1
        return tuple(arguments)

    def _argument(self) -> Argument:
        position = self.position
        at = self.starts[position]
        if self.kinds[position] == NAME:
            sign = self.kinds[position + 1]
            if sign == NAME and self._is_bound(position + 1):
                self.position = position + 3
                return Argument(self.words[position], self.expression(), False, at)
            if sign == ":=" or sign == "=>":
                self.position = position + 2
                empty = self.kinds[position + 2] in (",", ")")
                value = None if empty else self.expression()
                return Argument(self.words[position], value, sign == "=>", at)
        return Argument("", self.expression(), False, at)

    def _is_bound(self, position: int) -> bool:
        """Whether `REF=` stands there: a word and a sign that touch each other."""
        if self.words[position].upper() != "REF" or self.kinds[position + 1] != "=":
            return False
        return self.starts[position] + 3 == self.starts[position + 1]

    # initial values ------------------------------------------------------------------------

    def initial(self) -> Initial:
        """What follows `:=` in a declaration. Raises `Unexpected`."""
        position = self.position
        if self.kinds[position] == "[":
            return self.array_initial()
        if self._is_structure(position):
            found = self._struct_initial()
            if self.kinds[self.position] not in BINDING:
                return found
            self.position = position  # `(a := 0) OR b` only begins like a structure
        return self.expression()

    def _is_structure(self, position: int) -> bool:
        """Whether `(a :=` or `()` stands there."""
        kinds = self.kinds
        if kinds[position] != "(":
            return False
        first = kinds[position + 1]
        return first == ")" or (first == NAME and kinds[position + 2] == ":=")

    def array_initial(self) -> ArrayInitial:
        """`[1, 2(0), (a := 1)]`. Raises `Unexpected`."""
        at = self.expect("[")
        self.deeper()
        values: list[Initial | Repeated] = []
        while self.kinds[self.position] != "]":
            values.append(self.element())
            if not self.take(","):
                break
        self.expect("]", "',' or ']'")
        self.depth -= 1
        return ArrayInitial(tuple(values), at)

    def element(self) -> Initial | Repeated:
        """One value of an array, or several: `3(0)`. Raises `Unexpected`."""
        value = self._count() or self.initial()
        at = self.at
        # A name before the bracket reads as a call; which it is shows in what the name means.
        if not (isinstance(value, Literal | Name | Member) and self.take("(")):
            return value
        values: list[Initial] = []
        self.deeper()
        while self.kinds[self.position] != ")":
            values.append(self.initial())
            if not self.take(","):
                break
        self.expect(")", "',' or ')'")
        self.depth -= 1
        return Repeated(value, tuple(values), at)

    def _count(self) -> Expression | None:
        """The name before `((a := 1))` or `([1])`, which no call takes: it counts."""
        kinds = self.kinds
        last = self.position
        while kinds[last] == NAME and kinds[last + 1] == ".":
            last += 2
        if kinds[last] != NAME or kinds[last + 1] != "(":
            return None
        if kinds[last + 2] != "[" and not self._is_structure(last + 2):
            return None
        count: Expression = Name(self.words[self.position], self.at)
        self.position += 1
        while self.position <= last:
            count = self._member(count)
        return count

    def _struct_initial(self) -> StructInitial:
        at = self.expect("(")
        self.deeper()
        members: list[MemberInitial] = []
        while self.kinds[self.position] != ")":
            name = self.name("the name of a member")
            self.expect(":=")
            members.append(MemberInitial(name.name, self.initial(), name.at))
            if not self.take(","):
                break
        self.expect(")", "',' or ')'")
        self.depth -= 1
        return StructInitial(tuple(members), at)
