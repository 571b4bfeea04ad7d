"""JSON documents of PLC programs: what the built-in routines of `tc3_jsonxml/dom.st` do.

A program holds a document by a number, and each value in it by another; 0 is none. Values that
are removed, or of a document that was read again, are none from then on.

Source: method names of public projects and their symbol files.
"""

import json
import re
from base64 import b64decode
from binascii import unhexlify
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime, timedelta
from enum import IntEnum
from typing import Any
from weakref import WeakKeyDictionary

from achse.plc.routines.builtins import BuiltinContext, FunctionBody
from achse.plc.routines.document_texts import (
    LONGEST_TEXT,
    KeptDocuments,
    copy_part,
    copy_text,
    decoded,
    text_at,
)

_MOST_VALUES = 1_000_000
_DEEPEST = 256


class JsonKind(IntEnum):
    """Kind of a JSON value."""

    NULL = 0
    FALSE = 1
    TRUE = 2
    OBJECT = 3
    ARRAY = 4
    STRING = 5
    NUMBER = 6


class _Placing(IntEnum):
    """Placement of a new value."""

    MEMBER = 0
    PUSH = 1
    SET = 2


class _Value:
    """A value, its name if it is a member, and what it is in."""

    __slots__ = ("content", "end", "kind", "name", "number", "parent")

    def __init__(self, kind: JsonKind, content: Any = None, name: str = "") -> None:
        self.kind = kind
        self.content = content
        self.name = name
        self.parent: _Value | None = None
        self.number = 0
        self.end = 0
        """Number that ends a walk over an object or array."""

    def python_value(self) -> Any:
        """Return the value as `json.dumps` takes it. Members of one name: the last counts."""
        if self.kind is JsonKind.OBJECT:
            return {item.name: item.python_value() for item in self.content}
        if self.kind is JsonKind.ARRAY:
            return [item.python_value() for item in self.content]
        return self.content


class JsonDocuments(KeptDocuments[_Value]):
    """The documents of one PLC."""

    def __init__(self) -> None:
        super().__init__()
        self._values: dict[int, _Value] = {}

    # documents -------------------------------------------------------------------------------

    def read(self, document: int, text: str) -> bool:
        """Put a text into a document; whether it is JSON. If not, the document is empty."""
        self._drop(self._roots[document])
        self._roots[document] = self._keep(_Value(JsonKind.NULL), None)
        try:
            parsed = json.loads(text, object_pairs_hook=_Members)
            root = self._value(parsed, 0)
        except (ValueError, RecursionError):
            return False
        self._drop(self._roots[document])
        self._roots[document] = self._keep(root, None)
        return True

    def _value(self, parsed: Any, depth: int) -> _Value:
        if depth > _DEEPEST:
            raise ValueError("too deep")
        if isinstance(parsed, _Members):
            value = _Value(JsonKind.OBJECT, [])
            for name, item in parsed:
                member = self._value(item, depth + 1)
                member.name = name
                value.content.append(member)
            return value
        if isinstance(parsed, list):
            return _Value(JsonKind.ARRAY, [self._value(item, depth + 1) for item in parsed])
        if isinstance(parsed, str):
            return _Value(JsonKind.STRING, parsed)
        if parsed is None:
            return _Value(JsonKind.NULL)
        if isinstance(parsed, bool):
            return _Value(JsonKind.TRUE if parsed else JsonKind.FALSE, parsed)
        return _Value(JsonKind.NUMBER, parsed)

    def _empty(self) -> _Value:
        return _Value(JsonKind.NULL)

    def _keep(self, value: _Value, parent: _Value | None) -> _Value:
        waiting: list[tuple[_Value, _Value | None]] = [(value, parent)]
        while waiting:
            here, above = waiting.pop()
            here.parent = above
            here.number = self._next()
            if len(self._values) < _MOST_VALUES:
                self._values[here.number] = here
            if here.kind in (JsonKind.OBJECT, JsonKind.ARRAY):
                here.end = self._next()
                waiting += ((item, here) for item in reversed(here.content))
        return value

    def _drop(self, value: _Value) -> None:
        for item in _all(value):
            self._values.pop(item.number, None)

    # values ----------------------------------------------------------------------------------

    def value(self, number: int) -> _Value | None:
        return self._values.get(number)

    def items(self, number: int) -> list[_Value]:
        """Return the items of an object or array; empty for others."""
        value = self._values.get(number)
        return value.content if value is not None and _is_container(value) else []

    def find(self, number: int, name: str) -> int:
        """Return the member of that name; 0 if there is none."""
        value = self._values.get(number)
        if value is None or value.kind is not JsonKind.OBJECT:
            return 0
        return next((item.number for item in value.content if item.name == name), 0)

    def first(self, number: int) -> int:
        """Return the first item, or what a walk over it ends with."""
        items = self.items(number)
        return items[0].number if items else self.last(number)

    def last(self, number: int) -> int:
        """Return the number that ends a walk over an object or array."""
        value = self._values.get(number)
        return value.end if value is not None else 0

    def following(self, number: int) -> int:
        """Return the item behind one."""
        value = self._values.get(number)
        if value is None or value.parent is None:
            return 0
        items = value.parent.content
        place = next(index for index, item in enumerate(items) if item is value) + 1
        next_item: int = items[place].number if place < len(items) else value.parent.end
        return next_item

    def put(self, number: int, where: int, name: str, kind: int, content: Any) -> int:
        """Return a new value in, behind or instead of another; its number, 0 if that cannot be."""
        target = self._values.get(number)
        if target is None or len(self._values) >= _MOST_VALUES:
            return 0
        new = _Value(JsonKind(kind), [] if kind in _CONTAINERS else content, name)
        if where == _Placing.SET:
            return self._replace(target, new)
        wanted = JsonKind.OBJECT if where == _Placing.MEMBER else JsonKind.ARRAY
        if target.kind is JsonKind.NULL:  # of a new document: it becomes what is put into it
            target.kind, target.content, target.end = wanted, [], self._next()
        if target.kind is not wanted:
            return 0
        target.content.append(self._keep(new, target))
        return new.number

    def put_text(self, number: int, where: int, name: str, text: str) -> int:
        """Return a value as JSON in, behind or instead of another; its number, 0 if that cannot
        be."""
        try:
            value = self._value(json.loads(text, object_pairs_hook=_Members), 0)
        except (ValueError, RecursionError):
            return 0
        place = self.put(number, where, name, JsonKind.NULL, None)
        return self._replace(self._values[place], value) if place else 0

    def _replace(self, target: _Value, new: _Value) -> int:
        for item in _all(target):
            if item is not target:
                self._values.pop(item.number, None)
        target.kind, target.content = new.kind, new.content
        if _is_container(target):
            target.end = self._next()
            for item in target.content:
                self._keep(item, target)
        return target.number

    def remove(self, number: int) -> bool:
        """Take a value out of what it is in."""
        value = self._values.get(number)
        if value is None or value.parent is None:
            return False
        value.parent.content.remove(value)
        self._drop(value)
        return True

    def clear(self, number: int) -> bool:
        """Take everything out of an object or array."""
        value = self._values.get(number)
        if value is None or not _is_container(value):
            return False
        for item in list(value.content):
            self._drop(item)
        value.content.clear()
        return True

    def text(self, number: int, *, as_json: bool) -> str:
        """Return a value as JSON without blanks, or a text as it is."""
        value = self._values.get(number)
        if value is None:
            return ""
        if not as_json:
            return value.content if value.kind is JsonKind.STRING else ""
        return json.dumps(value.python_value(), ensure_ascii=False, separators=(",", ":"))


class _Members(list[tuple[str, Any]]):
    """The members of an object in order."""


_CONTAINERS = (JsonKind.OBJECT, JsonKind.ARRAY)


def _is_container(value: _Value) -> bool:
    return value.kind in _CONTAINERS


def _all(value: _Value) -> Iterator[_Value]:
    waiting = [value]
    while waiting:
        here = waiting.pop()
        yield here
        if _is_container(here):
            waiting += here.content


# what programs call ---------------------------------------------------------------------------

_of_plc: "WeakKeyDictionary[BuiltinContext, JsonDocuments]" = WeakKeyDictionary()


def _documents(plc: BuiltinContext) -> JsonDocuments:
    documents = _of_plc.get(plc)
    if documents is None:
        documents = _of_plc[plc] = JsonDocuments()
    return documents


def _named(name: Any) -> str:
    return decoded(name) if isinstance(name, bytes) else str(name)


def _copied(plc: BuiltinContext, number: int, as_json: bool, address: int, size: int) -> int:
    return copy_text(plc, _documents(plc).text(number, as_json=as_json), address, size)


def _bytes_of(plc: BuiltinContext, number: int, base: int, address: int, size: int) -> int:
    """Return the number of bytes that a text has in base 16 or 64, -1 if it has none; they are
    stored if they fit."""
    value = _documents(plc).value(number)
    text = None if value is None else value.content
    if not isinstance(text, str):
        return -1
    try:
        data = unhexlify(text) if base == 16 else b64decode(text, validate=True)
    except ValueError:
        return -1
    if address and len(data) <= size:
        plc.store_bytes(address, data)
    return len(data)


def _stamp(plc: BuiltinContext, number: int) -> int:
    """Return a time in ISO 8601 as steps of 100 ns since 1601, -1 if the text is none."""
    value = _documents(plc).value(number)
    text = None if value is None else value.content
    if not isinstance(text, str) or (match := _ISO_8601.fullmatch(text)) is None:
        return -1
    try:
        moment = datetime.fromisoformat(match[1] + (match[3] or "Z").replace("Z", "+00:00"))
        since = (moment - _YEAR_1601) // timedelta(seconds=1)
    except (ValueError, OverflowError):
        return -1
    return since * 10_000_000 + int((match[2] or "").ljust(7, "0")[:7])


_ISO_8601 = re.compile(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d)(?:\.(\d+))?(Z|[+-]\d\d:\d\d)?", re.ASCII)
_YEAR_1601 = datetime(1601, 1, 1, tzinfo=UTC)


def _put(
    plc: BuiltinContext,
    number: int,
    where: int,
    name: Any,
    kind: int,
    whole: int,
    real: float,
    is_real: bool,
    text: int,
) -> int:
    documents = _documents(plc)
    if kind == _AS_JSON:
        return documents.put_text(number, where, _named(name), text_at(plc, text))
    content: Any = {
        JsonKind.TRUE: True,
        JsonKind.FALSE: False,
        JsonKind.NUMBER: real if is_real else whole,
    }.get(JsonKind(kind))
    if kind == JsonKind.STRING:
        content = text_at(plc, text)
    return documents.put(number, where, _named(name), kind, content)


_AS_JSON = 7
"""A kind of `_put`: the text is JSON."""


def _number(plc: BuiltinContext, number: int) -> Any:
    value = _documents(plc).value(number)
    content = None if value is None else value.content
    return content if isinstance(content, int | float) else 0


def _real(plc: BuiltinContext, number: int) -> float:
    try:
        return float(_number(plc, number))
    except OverflowError:
        return float("inf")


def _whole(low: int, high: int) -> FunctionBody:
    def get(plc: BuiltinContext, number: int) -> int:
        value = _number(plc, number)
        if isinstance(value, float) and not -1e19 < value < 1e20:
            return 0
        return max(low, min(int(value), high))

    return get


def _kind(plc: BuiltinContext, number: int) -> int:
    value = _documents(plc).value(number)
    return -1 if value is None else int(value.kind)


def _is_real(plc: BuiltinContext, number: int) -> bool:
    return isinstance(_number(plc, number), float)


def _name(plc: BuiltinContext, number: int) -> bytes:
    value = _documents(plc).value(number)
    return b"" if value is None else value.name.encode("utf-8")[:255]


def _item(plc: BuiltinContext, number: int, index: int) -> int:
    items = _documents(plc).items(number)
    return items[index].number if index < len(items) else 0


def _on(method: Callable[..., Any]) -> FunctionBody:
    """Return a method of `JsonDocuments` as a routine of the PLC."""
    return lambda plc, *arguments: method(_documents(plc), *arguments)


JSON_FUNCTIONS: Mapping[str, FunctionBody] = {
    "json_start": _on(JsonDocuments.start),
    "json_end": _on(JsonDocuments.end),
    "json_root": _on(JsonDocuments.root),
    "json_read": lambda plc, document, text: _documents(plc).read(document, text_at(plc, text)),
    "json_feed": lambda plc, document, address, size, is_last: _documents(plc).feed(
        document, plc.load_bytes(address, size) if size else b"", is_last
    ),
    "json_part": lambda plc, number, offset, address, size: copy_part(
        plc, _documents(plc).text(number, as_json=True), offset, address, size
    ),
    "json_find": lambda plc, number, name: _documents(plc).find(number, _named(name)),
    "json_first": _on(JsonDocuments.first),
    "json_last": _on(JsonDocuments.last),
    "json_following": _on(JsonDocuments.following),
    "json_remove": _on(JsonDocuments.remove),
    "json_clear": _on(JsonDocuments.clear),
    "json_count": lambda plc, number: len(_documents(plc).items(number)),
    "json_item": _item,
    "json_kind": _kind,
    "json_name": _name,
    "json_is_real": _is_real,
    "json_real": _real,
    "json_int": _whole(-(2**63), 2**63 - 1),
    "json_uint": _whole(0, 2**64 - 1),
    "json_text": lambda plc, number, as_json: (
        _documents(plc).text(number, as_json=as_json).encode("utf-8")[:LONGEST_TEXT]
    ),
    "json_length": lambda plc, number, as_json: len(
        _documents(plc).text(number, as_json=as_json).encode("utf-8")
    ),
    "json_copy": _copied,
    "json_bytes": _bytes_of,
    "json_stamp": _stamp,
    "json_put": _put,
}
"""Built-in functions of Tc3_JsonXml, by key."""
