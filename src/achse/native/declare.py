"""Records: fields declared once in classes, from which follow both forms a record can have.

A class of fields has an annotation for each field (`float`, `int` or a list of these) and as value
its default: a number, a list of numbers, or a `Slot` that says more. All values are 64 bits wide,
so that a kernel means the same on a plain object and on memory. A field can refer to a record of
another layout (an object, or its address in memory), or hold one or several within its own record.
A record that holds no references is a value: a kernel may `assign` it to another one as a whole and
`reset` it, and pass it to and return it from functions.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, TypeVar


@dataclass(slots=True)
class Slot:
    """One declared value: `length` 0 is a scalar, otherwise a fixed array."""

    default: float | int
    length: int = 0
    name: str = ""
    offset: int = 0
    """Position in the record, in words of 8 bytes."""
    refers: "RecordLayout[Any] | None" = None
    """Of a reference: the layout of the record it leads to."""
    holds: "RecordLayout[Any] | None" = None
    """Of a record within, or `length` of them: its layout."""

    @property
    def is_real(self) -> bool:
        return isinstance(self.default, float)

    @property
    def words(self) -> int:
        return (self.length or 1) * (self.holds.words if self.holds is not None else 1)

    @property
    def form(self) -> str:
        """Its values for `struct`."""
        if self.holds is not None:
            return self.holds.codes * (self.length or 1)
        return f"{self.length or 1}{'d' if self.is_real else 'q'}"

    @property
    def fresh(self) -> Any:
        """The value in a fresh record; a reference leads nowhere yet."""
        if self.refers is not None:
            return None
        if self.holds is not None:
            record = self.holds.plain
            return [record() for _ in range(self.length)] if self.length else record()
        return [self.default] * self.length if self.length else self.default


LINE_WORDS = 8
"""Words that a processor takes from memory at once."""

SlotT = TypeVar("SlotT", bound=Slot)


# Any: declarations are annotated with the class of the record
def reference(layout: "RecordLayout[Any]", kind: type[SlotT] | type[Slot] = Slot) -> Any:
    """Declares a field that refers to a record of `layout`; a kernel follows it, never sets it."""
    return kind(0, refers=layout)


def within(
    layout: "RecordLayout[Any]", kind: type[SlotT] | type[Slot] = Slot, length: int = 0
) -> Any:
    """Declares a field that holds a record of `layout`, or a list of `length` of them."""
    return kind(0, length, holds=layout)


@dataclass(frozen=True, eq=False)
class RecordLayout(Generic[SlotT]):
    """A record in memory: its fields one behind the other, and how many `words` it takes."""

    name: str
    fields: dict[str, SlotT]
    words: int

    @cached_property
    def records_within(self) -> "list[tuple[SlotT, RecordLayout[Any]]]":
        """The fields that hold records, with the layouts of these."""
        return [(row, row.holds) for row in self.fields.values() if row.holds is not None]

    @cached_property
    def codes(self) -> str:
        """The kinds of all values, for `struct`."""
        return "".join(row.form for row in self.fields.values())

    @cached_property
    def form(self) -> struct.Struct:
        """All values one behind the other."""
        return struct.Struct("=" + self.codes)

    @cached_property
    def plain(self) -> type:
        """A class of plain objects with these fields, for a kernel that runs as it is."""
        source = "def begin(record):\n pass\n"
        scope: dict[str, Any] = {}
        for name, row in self.fields.items():
            value = f"value_{name}"
            if row.holds is None:
                scope[value] = row.fresh
                value += ".copy()" if row.length else ""
            else:
                scope[value] = row.holds.plain
                value += "()"
                value = f"[{value} for _ in range({row.length})]" if row.length else value
            source += f" record.{name} = {value}\n"
        exec(source, scope)
        namespace = {"__slots__": tuple(self.fields), "__init__": scope["begin"], "layout": self}
        return type("PlainRecord", (), namespace)

    @cached_property
    def copy(self) -> Callable[[Any, Any], None]:
        """A function of target and source that copies all values, one statement for each field."""
        source = "def copy(target, source):\n"
        for name, row in self.fields.items():
            own, other = f"target.{name}", f"source.{name}"
            if row.length:
                source += f" own, other = {own}, {other}\n for n in range({row.length}):\n"
                source += "  assign(own[n], other[n])\n" if row.holds else "  own[n] = other[n]\n"
            elif row.holds is not None:
                source += f" assign({own}, {other})\n"
            else:
                source += f" {own} = {other}\n"
        scope: dict[str, Any] = {"assign": assign}
        exec(source, scope)
        copy: Callable[[Any, Any], None] = scope["copy"]
        return copy

    @cached_property
    def fresh(self) -> Any:
        """A fresh record, to copy from."""
        return self.plain()

    @cached_property
    def is_value(self) -> bool:
        """True if neither the record nor those within refer to others."""
        return all(
            row.refers is None and (row.holds is None or row.holds.is_value)
            for row in self.fields.values()
        )


def lay_out(
    name: str,
    sections: Iterable[type],
    kind: type[SlotT],
    first: Iterable[str] = (),
    *,
    whole_lines: bool = False,
) -> RecordLayout[SlotT]:
    """Return the layout of a record with the fields of all sections; `kind` describes plain
    defaults.

    The fields `first` are in front, in their order; KeyError for an unknown field. Records of
    `whole_lines` have words behind them that no field uses: each begins in a line of its own.
    """
    fields: dict[str, SlotT] = {}
    for section in sections:
        for field in section.__annotations__:
            if field in fields:
                raise TypeError(f"field {field!r} is declared twice")
            declared = vars(section)[field]
            if isinstance(declared, list):
                row = kind(declared[0], len(declared))
            else:
                # a class may be in several records, at another place in each
                row = replace(declared) if isinstance(declared, kind) else kind(declared)
            if row.holds is not None and any(each.refers for each in row.holds.fields.values()):
                raise TypeError(f"field {field!r} holds a record that refers to others")
            row.name = field
            fields[field] = row
    ordered = {field: fields[field] for field in first} | fields
    offset = 0
    for row in ordered.values():
        row.offset = offset
        offset += row.words
    return RecordLayout(name, ordered, offset + (-offset % LINE_WORDS if whole_lines else 0))


def plain_record(layout: RecordLayout[Any]) -> type:
    """Return a class of plain objects with these fields, for a kernel that runs as it is."""
    return layout.plain


def assign(target: Any, source: Any) -> None:
    """Give a record all values of another one of its layout; TypeError if it has another layout.

    Both are plain records, views or structures over memory. In a kernel it is one copy.
    """
    layout: RecordLayout[Any] = target.layout
    if source.layout is not layout:
        raise TypeError(f"cannot assign a {source.layout.name}: expected a {layout.name}")
    layout.copy(target, source)


def reset(record: Any) -> None:
    """Give a record, a plain one or another, the values of a fresh one."""
    layout: RecordLayout[Any] = record.layout
    layout.copy(record, layout.fresh)


def pack(layout: RecordLayout[Any], record: object) -> bytes:
    """Return the record's bytes, equal for both forms when every value is equal; references are
    0."""
    values: list[float] = []
    _collect(layout, record, values)
    return layout.form.pack(*values)


def _collect(layout: RecordLayout[Any], record: object, values: list[float]) -> None:
    for name, row in layout.fields.items():
        value: Any = 0 if row.refers is not None else getattr(record, name)
        each = value if row.length else (value,)
        if row.holds is None:
            values.extend(each)
        else:
            for inner in each:
                _collect(row.holds, inner, values)
