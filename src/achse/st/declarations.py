"""Declarations: types, variables and their blocks.

Source: IEC 61131-3 (2013) tables 11, 13 and 14.
"""

from collections.abc import Collection

from achse.st.cursor import Unexpected
from achse.st.expressions import BINDING
from achse.st.lexer import END, NAME
from achse.st.statements import StatementParser
from achse.st.tree import (
    NO_NOTE,
    Address,
    Argument,
    ArrayInitial,
    ArrayOf,
    Declaration,
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
from achse.st.units import TypeDeclaration
from achse.st.words import BLOCK_WORDS, MODIFIERS, QUALIFIERS, SECTIONS

__all__ = ["DeclarationParser"]

_IN_STATEMENTS = frozenset((":=", "(", "^", "["))
_IN_TYPE_NAMES = frozenset((".", "<", "("))
_MEMBER_ENDS = frozenset(("END_STRUCT", "END_UNION"))


class DeclarationParser(StatementParser):
    """Reads types and variables. A fault costs the declaration it is in."""

    # types ---------------------------------------------------------------------------------

    def type_spec(self) -> TypeSpec:
        """A type as it stands after the colon. Raises `Unexpected`."""
        position = self.position
        kind = self.kinds[position]
        if kind == NAME:
            if self.kinds[position + 1] not in _IN_TYPE_NAMES:
                self.position = position + 1
                return NamedType(self.words[position], (), self.starts[position])
            named = self.type_name()
            if self.kinds[self.position] == "(":
                return self._subrange(named)
            return named
        if kind == "STRING" or kind == "WSTRING":
            return self._string(kind)
        if kind == "(":
            return self._enum(None)
        self.deeper()
        at = self.at
        spec: TypeSpec
        if kind == "ARRAY":
            spec = self._array()
        elif kind == "POINTER" or kind == "REFERENCE":
            self.position = position + 1
            self.expect("TO", "TO")
            make = PointerTo if kind == "POINTER" else ReferenceTo
            spec = make(self.type_spec(), at)
        elif kind == "STRUCT":
            spec = StructOf(self._members("END_STRUCT"), at)
        elif kind == "UNION":
            spec = UnionOf(self._members("END_UNION"), at)
        else:
            raise self.unexpected("a type")
        self.depth -= 1
        return spec

    def type_name(self, expected: str = "the name of a type") -> NamedType:
        """The name of a type, with its arguments if it is generic. Raises `Unexpected`."""
        found = self.path(expected)
        generics: list[Expression] = []
        if self.take("<"):
            self.deeper()
            generics.append(self.expression(BINDING[">"]))
            while self.take(","):
                generics.append(self.expression(BINDING[">"]))
            self.expect(">", "',' or '>'")
            self.depth -= 1
        return NamedType(found.name, tuple(generics), found.at)

    def _subrange(self, named: NamedType) -> TypeSpec:
        """`INT (0..100)`; anything else in the brackets is left to the caller."""
        position = self.position
        if self.kinds[position + 1] == NAME and self.kinds[position + 2] == ":=":
            return named
        self.position = position + 1
        if self.kinds[self.position] == ")":
            self.position = position
            return named
        low = self.reference()
        if self.kinds[self.position] != "..":
            self.position = position
            return named
        at = self.expect("..")
        high = self.reference()
        self.expect(")")
        return Subrange(named, Range(low, high, at), at)

    def _string(self, family: str) -> StringOf:
        at = self.at
        self.position += 1
        for opening, closing in ("()", "[]"):
            if self.take(opening):
                length = self.reference()
                self.expect(closing)
                return StringOf(family, length, at)
        return StringOf(family, None, at)

    def _array(self) -> ArrayOf:
        at = self.expect("ARRAY")
        self.expect("[")
        dimensions = [self._dimension()]
        while self.take(","):
            dimensions.append(self._dimension())
        self.expect("]", "',' or ']'")
        self.expect("OF", "OF")
        return ArrayOf(tuple(dimensions), self.type_spec(), at)

    def _dimension(self) -> Range | None:
        if self.take("*"):
            return None
        low = self.reference()
        at = self.expect("..")
        return Range(low, self.reference(), at)

    def _enum(self, base: NamedType | None) -> EnumOf:
        at = self.expect("(")
        values: list[EnumValue] = []
        while self.kinds[self.position] != ")":
            first = self.position
            name = self.name("the name of a value")
            value = self.expression() if self.take(":=") else None
            last = self.position - 1
            if self.kinds[self.position] == ",":
                last = last if self.starts[last] in self.tokens.after else self.position
            values.append(EnumValue(name.name, value, self.note(first, last), name.at))
            if not self.take(","):
                break
        self.expect(")", "',' or ')'")
        if not values:
            raise Unexpected(at, "expected at least one value of the enumeration")
        if base is None and self.kinds[self.position] == NAME:
            base = self.type_name()
        return EnumOf(tuple(values), base, at)

    def _members(self, end: str) -> tuple[Declaration, ...]:
        self.position += 1
        members = self._declarations(_MEMBER_ENDS)
        self.expect(end, end)
        return members

    def type_declarations(self) -> list[TypeDeclaration]:
        """`TYPE … END_TYPE`, which may declare several types."""
        first = self.position
        self.expect("TYPE")
        modifiers = self.modifiers()
        found: list[TypeDeclaration] = []
        while self.kinds[self.position] == NAME:
            position = self.position
            depth = self.depth
            try:
                found.append(self._type_declaration(first if not found else position, modifiers))
            except Unexpected as fault:
                self.report(fault)
                self.depth = depth
                self.skip_to(_MEMBER_ENDS, position)
                while self.kinds[self.position] in _MEMBER_ENDS:
                    self.position += 1
                    self.take(";")
        self.expect("END_TYPE", "the name of a type or END_TYPE" if not found else "END_TYPE")
        self.take(";")
        return found

    def _type_declaration(self, first: int, modifiers: tuple[str, ...]) -> TypeDeclaration:
        start = self.position
        name = self.name()
        extends = self.type_name() if self.take("EXTENDS") else None
        self.expect(":", "':'" if extends else "EXTENDS or ':'")
        last = self.position - 1
        spec = self.type_spec()
        if isinstance(spec, NamedType) and self.kinds[self.position] == "(":
            spec = self._enum(spec)
        initial = self.initial() if self.take(":=") else None
        if isinstance(spec, StructOf | UnionOf):
            self.take(";")
        else:
            self.expect_end(";")
            if not isinstance(spec, EnumOf):
                last = self.position - 1
        note = self.note(first, last)
        if start != first:
            note = _joined(note, self.note(start, start))
        return TypeDeclaration(name.name, modifiers, extends, spec, initial, note, name.at)

    def modifiers(self) -> tuple[str, ...]:
        """PUBLIC, ABSTRACT and the like, as long as another name follows."""
        found = []
        while (
            self.kinds[self.position] == NAME
            and self.kinds[self.position + 1] == NAME
            and self.words[self.position].upper() in MODIFIERS
        ):
            found.append(self.words[self.position].upper())
            self.position += 1
        return tuple(found)

    # variables -----------------------------------------------------------------------------

    def var_blocks(self, sections: Collection[str] = SECTIONS) -> tuple[VarBlock, ...]:
        """All VAR blocks that follow each other."""
        blocks = []
        while self.kinds[self.position] in sections:
            blocks.append(self._var_block())
        return tuple(blocks)

    def _var_block(self) -> VarBlock:
        first = self.position
        section = self.kinds[first]
        at = self.at
        self.position = first + 1
        qualifiers: list[str] = []
        while (
            self.kinds[self.position] == NAME
            and self.kinds[self.position + 1] not in (":", ",", "AT", ".")
            and self.words[self.position].upper() in QUALIFIERS
        ):
            qualifiers.append(self.words[self.position].upper())
            self.position += 1
        note = self.note(first, first)
        variables = self._declarations(frozenset())
        if self.take("END_VAR"):
            self.take(";")
        else:
            self.report(self.unexpected("the name of a variable or END_VAR"))
        return VarBlock(section, tuple(qualifiers), variables, note, at)

    def _declarations(self, ends: frozenset[str]) -> tuple[Declaration, ...]:
        """Declarations up to a word of `ends` or of a block."""
        found: list[Declaration] = []
        kinds = self.kinds
        while True:
            position = self.position
            kind = kinds[position]
            if kind == ";":
                self.position = position + 1
                continue
            if kind != NAME and (kind in BLOCK_WORDS or kind in ends or kind == END):
                return tuple(found)
            depth = self.depth
            try:
                if kind != NAME or kinds[position + 1] in _IN_STATEMENTS:
                    if not ends and self._is_body():
                        return tuple(found)
                    if kind != NAME:
                        raise self.unexpected("the name of a variable")
                found.append(self._declaration())
            except Unexpected as fault:
                self.report(fault)
                self.depth = depth
                self.skip_to(ends, position)

    def _is_body(self) -> bool:
        """Whether END_VAR is missing and statements have begun."""
        position = self.position
        while self.kinds[position] not in BLOCK_WORDS and self.kinds[position] != END:
            position += 1
        return self.kinds[position] != "END_VAR"

    def _initial_of(self, spec: TypeSpec) -> Initial:
        """The initial value; that of an array may stand without brackets, as in TwinCAT 2:
        `:= 1, 2, 3(0);`, `:= (a := 0), (a := 1);`."""
        start = self.position
        initial = self.initial()
        kind = self.kinds[self.position]
        if kind != "," and not (kind == "(" and isinstance(spec, ArrayOf)):
            return initial
        self.position = start
        at = self.at
        values = [self.element()]
        while self.take(","):
            values.append(self.element())
        return ArrayInitial(tuple(values), at)

    def _declaration(self) -> Declaration:
        kinds = self.kinds
        first = self.position
        names = [Name(self.words[first], self.starts[first])]
        self.position = first + 1
        kind = kinds[first + 1]
        address = None
        if kind == ":":
            self.position = first + 2
        else:
            if kind == ".":
                self.position = first
                names = [self.path()]
            while self.take(","):
                names.append(self.name())
            if self.take("AT"):
                at = self.expect("address", "an address like %IX0.3 or %Q*")
                address = Address(self.words[self.position - 1], at)
            self.expect(":", "':'" if address else "',', AT or ':'")
        spec = self.type_spec()
        arguments: tuple[Argument, ...] | ArrayInitial = ()
        initial: Initial | None = None
        is_reference = False
        kind = kinds[self.position]
        if kind == "(":
            arguments = self.arguments()
            kind = kinds[self.position]
        elif kind == "[":
            arguments = self.array_initial()
            kind = kinds[self.position]
        if kind == ":=":
            self.position += 1
            initial = self._initial_of(spec)
        elif kind == NAME and self.setter() == "REF=":
            self.position += 2
            initial = self.expression()
            is_reference = True
        if kinds[self.position] == ";":
            self.position += 1
        else:
            self.expect_end(";", "';'" if initial is not None else "':=' or ';'")
        last = self.position - 1
        if self.starts[last] in self.tokens.after or self.starts[first] in self.tokens.before:
            note = self.note(first, last)
        else:
            note = NO_NOTE
        return Declaration(tuple(names), address, spec, arguments, initial, note, is_reference)


def _joined(first: Note, second: Note) -> Note:
    if second is NO_NOTE:
        return first
    comment = "\n".join(part for part in (first.comment, second.comment) if part)
    return Note(comment, first.attributes + second.attributes)
