"""Declarations: types, variables and their blocks.

Source: IEC 61131-3 (2013) tables 11, 13 and 14.
"""

from collections.abc import Collection

from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import END, NAME
from achse.st.lexis.words import BLOCK_WORDS, MODIFIERS, QUALIFIERS, SECTIONS
from achse.st.syntax.cursor import Cursor, Unexpected
from achse.st.syntax.expressions import BINDING, ExpressionParser
from achse.st.syntax.tree import (
    NO_NOTE,
    Argument,
    ArrayInitial,
    ArrayOf,
    Declaration,
    DirectAddress,
    EnumOf,
    EnumValue,
    Expression,
    Initial,
    Name,
    NamedType,
    Note,
    PointerTo,
    Range,
    ReferenceTo,
    StringOf,
    StructOf,
    Subrange,
    TypeSpec,
    UnionOf,
    VarBlock,
)
from achse.st.syntax.units import TypeDeclaration

_IN_STATEMENTS = frozenset((":=", "(", "^", "["))
_IN_TYPE_NAMES = frozenset((".", "<", "("))
_MEMBER_ENDS = frozenset(("END_STRUCT", "END_UNION"))


class DeclarationParser:
    """Reads types and variables at a cursor. A fault costs the declaration it is in."""

    def __init__(self, cursor: Cursor) -> None:
        self._cursor = cursor
        self.expressions = self._expressions = ExpressionParser(cursor, self.type_spec)
        self._kinds = cursor.kinds
        self._words = cursor.words
        self._starts = cursor.starts

    # types ---------------------------------------------------------------------------------

    def type_spec(self) -> TypeSpec:
        """Parse a type as written after the colon. Raises `Unexpected`."""
        cursor = self._cursor
        position = cursor.position
        kind = self._kinds[position]
        if kind == NAME:
            if self._kinds[position + 1] not in _IN_TYPE_NAMES:
                cursor.position = position + 1
                return NamedType(self._words[position], (), self._starts[position])
            named = self.type_name()
            if self._kinds[cursor.position] == "(":
                return self._subrange(named)
            return named
        if kind == "STRING" or kind == "WSTRING":
            return self._string(kind)
        if kind == "(":
            return self._enum(None)
        cursor.deeper()
        at = cursor.at
        spec: TypeSpec
        if kind == "ARRAY":
            spec = self._array()
        elif kind == "POINTER" or kind == "REFERENCE":
            cursor.position = position + 1
            cursor.expect("TO", "TO")
            make = PointerTo if kind == "POINTER" else ReferenceTo
            spec = make(self.type_spec(), at)
        elif kind == "STRUCT":
            spec = StructOf(self._members("END_STRUCT"), at)
        elif kind == "UNION":
            spec = UnionOf(self._members("END_UNION"), at)
        else:
            raise cursor.unexpected("a type")
        cursor.depth -= 1
        return spec

    def type_name(self, expected: str = "the name of a type") -> NamedType:
        """Parse the name of a type, with its arguments if it is generic. Raises `Unexpected`."""
        cursor = self._cursor
        path = cursor.path(expected)
        generics: list[Expression] = []
        if cursor.take("<"):
            cursor.deeper()
            generics.append(self._expressions.expression(BINDING[">"]))
            while cursor.take(","):
                generics.append(self._expressions.expression(BINDING[">"]))
            cursor.expect(">", "',' or '>'")
            cursor.depth -= 1
        return NamedType(path.name, tuple(generics), path.at)

    def _subrange(self, named: NamedType) -> TypeSpec:
        """`INT (0..100)`; anything else in the brackets is left to the caller."""
        cursor = self._cursor
        position = cursor.position
        if self._kinds[position + 1] == NAME and self._kinds[position + 2] == ":=":
            return named
        cursor.position = position + 1
        if self._kinds[cursor.position] == ")":
            cursor.position = position
            return named
        low = self._expressions.reference()
        if self._kinds[cursor.position] != "..":
            cursor.position = position
            return named
        at = cursor.expect("..")
        high = self._expressions.reference()
        cursor.expect(")")
        return Subrange(named, Range(low, high, at), at)

    def _string(self, family: str) -> StringOf:
        cursor = self._cursor
        at = cursor.at
        cursor.position += 1
        for opening, closing in ("()", "[]"):
            if cursor.take(opening):
                length = self._expressions.reference()
                cursor.expect(closing)
                return StringOf(family, length, at)
        return StringOf(family, None, at)

    def _array(self) -> ArrayOf:
        cursor = self._cursor
        at = cursor.expect("ARRAY")
        cursor.expect("[")
        dimensions = [self._dimension()]
        while cursor.take(","):
            dimensions.append(self._dimension())
        cursor.expect("]", "',' or ']'")
        cursor.expect("OF", "OF")
        return ArrayOf(tuple(dimensions), self.type_spec(), at)

    def _dimension(self) -> Range | None:
        if self._cursor.take("*"):
            return None
        low = self._expressions.reference()
        at = self._cursor.expect("..")
        return Range(low, self._expressions.reference(), at)

    def _enum(self, base: NamedType | None) -> EnumOf:
        cursor = self._cursor
        at = cursor.expect("(")
        values: list[EnumValue] = []
        while self._kinds[cursor.position] != ")":
            first = cursor.position
            name = cursor.name("the name of a value")
            value = self._expressions.expression() if cursor.take(":=") else None
            last = cursor.position - 1
            if self._kinds[cursor.position] == ",":
                last = last if self._starts[last] in cursor.tokens.after else cursor.position
            values.append(EnumValue(name.name, value, cursor.note(first, last), name.at))
            if not cursor.take(","):
                break
        cursor.expect(")", "',' or ')'")
        if not values:
            raise Unexpected(
                at, "expected at least one value of the enumeration", Code.BAD_ENUMERATION
            )
        if base is None and self._kinds[cursor.position] == NAME:
            base = self.type_name()
        return EnumOf(tuple(values), base, at)

    def _members(self, end: str) -> tuple[Declaration, ...]:
        self._cursor.position += 1
        members = self._declarations(_MEMBER_ENDS)
        self._cursor.expect(end, end)
        return members

    def type_declarations(self) -> list[TypeDeclaration]:
        """`TYPE … END_TYPE`, which may declare several types."""
        cursor = self._cursor
        first = cursor.position
        cursor.expect("TYPE")
        modifiers = self.modifiers()
        declarations: list[TypeDeclaration] = []
        while self._kinds[cursor.position] == NAME:
            position = cursor.position
            depth = cursor.depth
            try:
                declarations.append(
                    self._type_declaration(first if not declarations else position, modifiers)
                )
            except Unexpected as fault:
                cursor.report(fault)
                cursor.depth = depth
                cursor.skip_to(_MEMBER_ENDS, position)
                while self._kinds[cursor.position] in _MEMBER_ENDS:
                    cursor.position += 1
                    cursor.take(";")
        cursor.expect(
            "END_TYPE", "the name of a type or END_TYPE" if not declarations else "END_TYPE"
        )
        cursor.take(";")
        return declarations

    def _type_declaration(self, first: int, modifiers: tuple[str, ...]) -> TypeDeclaration:
        cursor = self._cursor
        start = cursor.position
        name = cursor.name()
        extends = self.type_name() if cursor.take("EXTENDS") else None
        cursor.expect(":", "':'" if extends else "EXTENDS or ':'")
        last = cursor.position - 1
        spec = self.type_spec()
        if isinstance(spec, NamedType) and self._kinds[cursor.position] == "(":
            spec = self._enum(spec)
        initial = self._expressions.initial() if cursor.take(":=") else None
        if isinstance(spec, StructOf | UnionOf):
            cursor.take(";")
        else:
            cursor.expect_end(";")
            if not isinstance(spec, EnumOf):
                last = cursor.position - 1
        note = cursor.note(first, last)
        if start != first:
            note = _joined(note, cursor.note(start, start))
        return TypeDeclaration(name.name, modifiers, extends, spec, initial, note, name.at)

    def modifiers(self) -> tuple[str, ...]:
        """PUBLIC, ABSTRACT and the like, as long as another name follows."""
        cursor = self._cursor
        modifiers = []
        while (
            self._kinds[cursor.position] == NAME
            and self._kinds[cursor.position + 1] == NAME
            and self._words[cursor.position].upper() in MODIFIERS
        ):
            modifiers.append(self._words[cursor.position].upper())
            cursor.position += 1
        return tuple(modifiers)

    # variables -----------------------------------------------------------------------------

    def var_blocks(self, sections: Collection[str] = SECTIONS) -> tuple[VarBlock, ...]:
        """Parse all VAR blocks that follow each other."""
        blocks = []
        while self._kinds[self._cursor.position] in sections:
            blocks.append(self._var_block())
        return tuple(blocks)

    def _var_block(self) -> VarBlock:
        cursor = self._cursor
        first = cursor.position
        section = self._kinds[first]
        at = cursor.at
        cursor.position = first + 1
        qualifiers: list[str] = []
        while (
            self._kinds[cursor.position] == NAME
            and self._kinds[cursor.position + 1] not in (":", ",", "AT", ".")
            and self._words[cursor.position].upper() in QUALIFIERS
        ):
            qualifiers.append(self._words[cursor.position].upper())
            cursor.position += 1
        note = cursor.note(first, first)
        variables = self._declarations(frozenset(), is_config=section == "VAR_CONFIG")
        if cursor.take("END_VAR"):
            cursor.take(";")
        else:
            cursor.report(cursor.unexpected("the name of a variable or END_VAR"))
        return VarBlock(section, tuple(qualifiers), variables, note, at)

    def _declarations(
        self, ends: frozenset[str], *, is_config: bool = False
    ) -> tuple[Declaration, ...]:
        """Declarations up to a word of `ends` or of a block; VAR_CONFIG has `.a` for a global
        variable."""
        cursor = self._cursor
        declarations: list[Declaration] = []
        kinds = self._kinds
        while True:
            position = cursor.position
            kind = kinds[position]
            if kind == ";":
                cursor.position = position + 1
                continue
            if kind != NAME and (kind in BLOCK_WORDS or kind in ends or kind == END):
                return tuple(declarations)
            depth = cursor.depth
            try:
                if kind != NAME or kinds[position + 1] in _IN_STATEMENTS:
                    if not ends and self._is_body():
                        return tuple(declarations)
                    if kind != NAME and not (is_config and kind == "."):
                        raise cursor.unexpected("the name of a variable")
                declarations.append(self._declaration())
            except Unexpected as fault:
                cursor.report(fault)
                cursor.depth = depth
                cursor.skip_to(ends, position)

    def _is_body(self) -> bool:
        """Return True if END_VAR is missing and statements have begun."""
        position = self._cursor.position
        while self._kinds[position] not in BLOCK_WORDS and self._kinds[position] != END:
            position += 1
        return self._kinds[position] != "END_VAR"

    def _initial_of(self, spec: TypeSpec) -> Initial:
        """Parse the initial value; that of an array may stand without brackets, as in TwinCAT 2:
        `:= 1, 2, 3(0);`, `:= (a := 0), (a := 1);`."""
        cursor = self._cursor
        start = cursor.position
        initial = self._expressions.initial()
        kind = self._kinds[cursor.position]
        if kind != "," and not (kind == "(" and isinstance(spec, ArrayOf)):
            return initial
        cursor.position = start
        at = cursor.at
        values = [self._expressions.element()]
        while cursor.take(","):
            values.append(self._expressions.element())
        return ArrayInitial(tuple(values), at)

    def _declaration(self) -> Declaration:
        cursor = self._cursor
        kinds = self._kinds
        first = cursor.position
        names = [Name(self._words[first], self._starts[first])]
        cursor.position = first + 1
        kind = kinds[first + 1]
        address = None
        if kind == ":":
            cursor.position = first + 2
        else:
            if kinds[first] == ".":
                path = cursor.path()
                names = [Name(f".{path.name}", path.at)]
            elif kind == ".":
                cursor.position = first
                names = [cursor.path()]
            while cursor.take(","):
                names.append(cursor.name())
            if cursor.take("AT"):
                at = cursor.expect("address", "an address like %IX0.3 or %Q*")
                address = DirectAddress(self._words[cursor.position - 1], at)
            cursor.expect(":", "':'" if address else "',', AT or ':'")
        spec = self.type_spec()
        arguments: tuple[Argument, ...] | ArrayInitial = ()
        initial: Initial | None = None
        is_reference = False
        kind = kinds[cursor.position]
        if kind == "(":
            arguments = self._expressions.arguments()
            kind = kinds[cursor.position]
        elif kind == "[":
            arguments = self._expressions.array_arguments()
            kind = kinds[cursor.position]
        if kind == ":=":
            cursor.position += 1
            initial = self._initial_of(spec)
        elif kind == NAME and cursor.setter() == "REF=":
            cursor.position += 2
            initial = self._expressions.expression()
            is_reference = True
        if kinds[cursor.position] == ";":
            cursor.position += 1
        else:
            cursor.expect_end(";", "';'" if initial is not None else "':=' or ';'")
        last = cursor.position - 1
        if self._starts[last] in cursor.tokens.after or self._starts[first] in cursor.tokens.before:
            note = cursor.note(first, last)
        else:
            note = NO_NOTE
        return Declaration(tuple(names), address, spec, arguments, initial, note, is_reference)


def _joined(first: Note, second: Note) -> Note:
    if second is NO_NOTE:
        return first
    comment = "\n".join(part for part in (first.comment, second.comment) if part)
    return Note(comment, first.attributes + second.attributes)
