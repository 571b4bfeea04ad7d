"""Program organisation units, and the parser as a whole: a source in, units and faults out.

Source: IEC 61131-3 (2013) tables 19, 40, 47, 48 and 51.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeVar

from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.lexer import END, NAME, Defines
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.lexis.words import ACCESS, SECTIONS
from achse.st.syntax.cursor import Cursor, Unexpected
from achse.st.syntax.declarations import DeclarationParser
from achse.st.syntax.statements import StatementParser
from achse.st.syntax.tree import (
    NO_NOTE,
    Expression,
    Name,
    NamedType,
    Note,
    Statements,
    TypeSpec,
    VarBlock,
)
from achse.st.syntax.units import (
    Accessor,
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Namespace,
    Part,
    Program,
    Property,
    Unit,
)

P = TypeVar("P")

_UNIT_WORDS = ("FUNCTION_BLOCK", "FUNCTION", "PROGRAM", "INTERFACE", "TYPE", "VAR_GLOBAL")
_GLOBAL_SECTIONS = ("VAR_GLOBAL", "VAR_CONFIG", "VAR_EXTERNAL")
_PART_WORDS = ("METHOD", "PROPERTY", "ACTION")
_UNITS_WITH_PARTS = ("END_FUNCTION_BLOCK", "END_PROGRAM", "END_INTERFACE")
_AROUND = {
    "END_METHOD": _UNITS_WITH_PARTS,
    "END_ACTION": _UNITS_WITH_PARTS,
    "END_GET": ("END_PROPERTY", *_UNITS_WITH_PARTS),
    "END_SET": ("END_PROPERTY", *_UNITS_WITH_PARTS),
}
"""The ends of what a body is in, which end it if its own end is missing."""
_AFTER_BODY = frozenset((END, *_UNIT_WORDS))


class Parsed(NamedTuple):
    """The units of a source in order, and all that is wrong with it."""

    source: Source
    units: tuple[Unit, ...]
    faults: tuple[Diagnostic, ...]

    def check(self) -> "Parsed":
        """Return the parsed source if it has no fault. Raises `SourceError`."""
        if self.faults:
            raise SourceError(self.faults)
        return self


def parse(source: Source | str, *, name: str = "GVL", defines: Defines = ()) -> Parsed:
    """Read a whole source; raises nothing, whatever the text.

    `name` is given to its VAR_GLOBAL blocks, which have none in the text. `defines` are names
    (or names with values) that `{IF defined (…)}` finds.
    """
    if isinstance(source, str):
        source = Source(source)
    parser = Parser(source, defines=defines)
    units = parser.attempt(lambda: parser.units(name))
    return Parsed(source, units or (), tuple(parser.faults))


def parse_expression(text: str) -> Expression:
    """One expression. Raises `SourceError`."""
    parser = Parser(Source(text))
    return _whole(parser, parser.expressions.expression)


def parse_statements(text: str) -> Statements:
    """Parse a list of statements. Raises `SourceError`."""
    parser = Parser(Source(text))
    return _whole(parser, parser.statements.statements)


def _whole(parser: "Parser", read: Callable[[], P]) -> P:
    result = parser.attempt(read)
    if parser.faults or result is None:
        raise SourceError(parser.faults)
    return result


class Parser:
    """Reads units. A fault costs at most the unit it is in.

    `cursor` walks the tokens; `expressions`, `statements` and `declarations` read at it.
    """

    def __init__(
        self, source: Source, start: int = 0, end: int | None = None, defines: Defines = ()
    ) -> None:
        self.cursor = self._cursor = Cursor(source, start, end, defines)
        self.declarations = DeclarationParser(self.cursor)
        self.expressions = self.declarations.expressions
        self.statements = StatementParser(self.cursor, self.expressions)
        self._kinds = self.cursor.kinds
        self._words = self.cursor.words
        self._starts = self.cursor.starts

    @property
    def faults(self) -> list[Diagnostic]:
        """The faults so far, in order of their places."""
        return self.cursor.faults

    def attempt(self, read: Callable[[], P]) -> P | None:
        """Return the result of `read` if the text ends after it, else report the fault."""
        cursor = self._cursor
        try:
            with collection_paused():  # trees have no cycles
                result = read()
            cursor.expect(END, "the end")
        except Unexpected as fault:
            cursor.report(fault)
            return None
        except RecursionError:
            # The caller's own stack left too little for what DEEPEST allows.
            cursor.report(Unexpected(cursor.at, "this nests too deep", Code.TOO_DEEP))
            return None
        return result

    def units(self, name: str, end: str = END) -> tuple[Unit, ...]:
        """Parse all units up to the end; VAR_GLOBAL blocks go into one list called `name`."""
        cursor = self._cursor
        units: list[Unit] = []
        blocks: list[VarBlock] = []
        place = 0
        while self._kinds[cursor.position] != end:
            position = cursor.position
            kind = self._kinds[position]
            try:
                if kind == END:
                    raise cursor.unexpected(end)
                if kind in _GLOBAL_SECTIONS:
                    place = place if blocks else cursor.at
                    blocks += self.declarations.var_blocks(_GLOBAL_SECTIONS)
                elif kind == "TYPE":
                    units += self.declarations.type_declarations()
                elif kind == ";":
                    cursor.position += 1
                elif kind == "ACTION" and units and isinstance(units[-1], FunctionBlock | Program):
                    # TwinCAT 2 writes the actions of a unit after its end.
                    unit = units[-1]
                    units[-1] = replace(unit, parts=(*unit.parts, self.action()))
                else:
                    units.append(self._unit(kind))
            except Unexpected as fault:
                cursor.report(fault)
                cursor.depth = 0
                if self._kinds[cursor.position] == END:
                    break
                self._skip_to_unit(position, end)
        if blocks:
            units.append(self._global_list(name, blocks, place))
        return tuple(units)

    def _skip_to_unit(self, start: int, end: str) -> None:
        cursor = self._cursor
        cursor.position = max(cursor.position, start + 1)
        while self._kinds[cursor.position] not in (*_UNIT_WORDS, END, end):
            cursor.position += 1

    def _global_list(self, name: str, blocks: list[VarBlock], at: int) -> GlobalList:
        """Return the list, with what its first block is noted with: attributes count for the
        list."""
        first = blocks[0]
        blocks[0] = VarBlock(first.section, first.qualifiers, first.variables, NO_NOTE, first.at)
        return GlobalList(name, tuple(blocks), first.note, at)

    def _unit(self, kind: str) -> Unit:
        if kind == "FUNCTION_BLOCK":
            return self.function_block()
        if kind == "PROGRAM":
            return self.program()
        if kind == "FUNCTION":
            return self.function()
        if kind == "INTERFACE":
            return self.interface()
        if self._cursor.is_word("NAMESPACE"):
            return self._namespace()
        raise self._cursor.unexpected(
            "TYPE, VAR_GLOBAL, FUNCTION_BLOCK, FUNCTION, PROGRAM or INTERFACE"
        )

    def _namespace(self) -> Namespace:
        cursor = self._cursor
        at = cursor.at
        cursor.position += 1
        cursor.deeper()
        if cursor.is_word("INTERNAL"):
            cursor.position += 1
        name = cursor.path()
        depth = cursor.depth
        units = self.units(name.name.rpartition(".")[2], "END_NAMESPACE")
        cursor.depth = depth - 1
        cursor.take("END_NAMESPACE")
        return Namespace(name.name, units, at)

    # units ---------------------------------------------------------------------------------

    def function_block(self, whole: bool = True) -> FunctionBlock:
        """Parse a function block; only its head and variables if it is not `whole`."""
        cursor = self._cursor
        modifiers, name, note = self._opening("FUNCTION_BLOCK")
        generic = self.declarations.var_blocks(("VAR_GENERIC",))
        extends = self.declarations.type_name() if cursor.take("EXTENDS") else None
        implements = self._type_names() if cursor.take("IMPLEMENTS") else ()
        cursor.take(";")
        blocks = generic + self.declarations.var_blocks()
        parts, body = self._inside("END_FUNCTION_BLOCK") if whole else ((), ())
        return FunctionBlock(
            name.name, modifiers, blocks, parts, body, note, name.at, extends, implements
        )

    def program(self, whole: bool = True) -> Program:
        """Parse a program; only its head and variables if it is not `whole`."""
        modifiers, name, note = self._opening("PROGRAM")
        self._cursor.take(";")
        blocks = self.declarations.var_blocks()
        parts, body = self._inside("END_PROGRAM") if whole else ((), ())
        return Program(name.name, modifiers, blocks, parts, body, note, name.at)

    def function(self, whole: bool = True) -> Function:
        """Parse a function; only its head and variables if it is not `whole`."""
        modifiers, name, note = self._opening("FUNCTION")
        returns = self._returns()
        self._cursor.take(";")
        blocks = self.declarations.var_blocks()
        body = self._body_up_to("END_FUNCTION") if whole else ()
        return Function(name.name, modifiers, returns, blocks, body, note, name.at)

    def interface(self, whole: bool = True) -> Interface:
        """Parse an interface; only its head if it is not `whole`."""
        modifiers, name, note = self._opening("INTERFACE")
        extends = self._type_names() if self._cursor.take("EXTENDS") else ()
        self._cursor.take(";")
        parts: tuple[Part, ...] = ()
        first = self._cursor.position
        if any(block.variables for block in self.declarations.var_blocks()):
            self._cursor.position = first  # empty blocks alone mean nothing
        if whole:
            parts = tuple(self._parts())
            self._end("END_INTERFACE", "METHOD, PROPERTY or END_INTERFACE")
        return Interface(name.name, modifiers, extends, parts, note, name.at)

    def _opening(self, word: str) -> tuple[tuple[str, ...], Name, Note]:
        """Return the beginning of a unit or part: its modifiers, name and note."""
        cursor = self._cursor
        first = cursor.position
        cursor.expect(word)
        modifiers = self.declarations.modifiers()
        name = cursor.name()
        return modifiers, name, cursor.note(first, cursor.position - 1)

    def _type_names(self) -> tuple[NamedType, ...]:
        names = [self.declarations.type_name()]
        # Editors leave a comma behind when they take the last name away.
        while self._cursor.take(",") and self._kinds[self._cursor.position] == NAME:
            names.append(self.declarations.type_name())
        return tuple(names)

    def _returns(self) -> TypeSpec | None:
        return self.declarations.type_spec() if self._cursor.take(":") else None

    # what is inside ------------------------------------------------------------------------

    def _inside(self, end: str) -> tuple[tuple[Part, ...], Statements]:
        """Methods, properties, actions and statements in any order, up to `end`."""
        parts: list[Part] = []
        body: Statements = ()
        known = self._cursor.fault_count
        while True:
            parts += self._parts()
            body += self.statements.statements()
            kind = self._kinds[self._cursor.position]
            if kind in _PART_WORDS:
                continue
            if kind == end or kind in _AFTER_BODY:
                break
            self._pass_over(end, known)
        self._end(end)
        return tuple(parts), body

    def _body_up_to(self, end: str) -> Statements:
        body: Statements = ()
        around = _AROUND.get(end, ())
        known = self._cursor.fault_count
        while True:
            body += self.statements.statements()
            kind = self._kinds[self._cursor.position]
            if kind == end or kind in _AFTER_BODY or kind in _PART_WORDS or kind in around:
                break
            self._pass_over(end, known)
        self._end(end)
        return body

    def _pass_over(self, end: str, known: int) -> None:
        """Go past what cannot be in a body. Variables are there if the head before them is at
        fault, which adds a fault to the `known` ones."""
        cursor = self._cursor
        if self._kinds[cursor.position] not in SECTIONS:
            cursor.report(cursor.unexpected(end))
            cursor.position += 1
            return
        if cursor.fault_count == known:
            cursor.report(cursor.unexpected(end))
        self.declarations.var_blocks()

    def _end(self, end: str, expected: str = "") -> None:
        cursor = self._cursor
        if cursor.take(end):
            cursor.take(";")
        else:
            cursor.report(cursor.unexpected(expected or end))

    def _parts(self) -> list[Part]:
        parts: list[Part] = []
        while (kind := self._kinds[self._cursor.position]) in _PART_WORDS:
            if kind == "METHOD":
                parts.append(self.method())
            elif kind == "PROPERTY":
                parts.append(self.property())
            else:
                parts.append(self.action())
        return parts

    def method(self, whole: bool = True) -> Method:
        """Parse a method; only its head and variables if it is not `whole`."""
        modifiers, name, note = self._opening("METHOD")
        returns = self._returns()
        self._cursor.take(";")
        blocks = self.declarations.var_blocks()
        body = self._body_up_to("END_METHOD") if whole else ()
        return Method(name.name, modifiers, returns, blocks, body, note, name.at)

    def property(self, whole: bool = True) -> Property:
        """Parse a property; only its head if it is not `whole`."""
        cursor = self._cursor
        modifiers, name, note = self._opening("PROPERTY")
        cursor.expect(":")
        type = self.declarations.type_spec()
        initial = self.expressions.initial() if cursor.take(":=") else None
        cursor.take(";")
        get: Accessor | None = None
        set: Accessor | None = None
        if whole:
            while cursor.is_word("GET") or cursor.is_word("SET"):
                if cursor.is_word("GET"):
                    get = self._accessor("END_GET")
                else:
                    set = self._accessor("END_SET")
            self._end("END_PROPERTY", "GET, SET or END_PROPERTY")
        return Property(name.name, modifiers, type, get, set, note, name.at, initial)

    def _accessor(self, end: str) -> Accessor:
        first = self._cursor.position
        self._cursor.position += 1
        accessor = self.accessor(first)
        body = self._body_up_to(end)
        return Accessor(accessor.modifiers, accessor.blocks, body, accessor.note, accessor.at)

    def accessor(self, first: int = 0) -> Accessor:
        """Modifiers and variables of a GET or SET, without its body."""
        cursor = self._cursor
        at = self._starts[first]
        note = cursor.note(first, first)
        words = []
        while (
            self._kinds[cursor.position] == NAME and self._words[cursor.position].upper() in ACCESS
        ):
            words.append(self._words[cursor.position].upper())
            cursor.position += 1
        return Accessor(tuple(words), self.declarations.var_blocks(), (), note, at)

    def action(self) -> Action:
        """Parse an action."""
        cursor = self._cursor
        first = cursor.position
        cursor.expect("ACTION")
        name = cursor.name()
        note = cursor.note(first, cursor.position - 1)
        cursor.take(":")
        return Action(name.name, self._body_up_to("END_ACTION"), note, name.at)
