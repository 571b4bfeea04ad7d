"""A kernel's functions as LLVM assembly: typed plain Python in, the same arithmetic out.

A kernel is functions on records whose parameters and results are annotated. `translate` starts at
one of them and takes in whatever it calls. What a function refers to beyond its own names (numbers,
tuples of numbers, enumerations, functions) is looked up in its module as it is now.

The language: assignments, also to several names; `if`, `while`, `for … in range(…)`, `break`,
`continue`, `return`; numbers, comparisons, `and`, `or`, `not`, `in` a tuple; fields, records that
fields refer to, elements of sequences and of a `bytearray`; `abs`, `min`, `max`, `len`, `int`,
`float`, `bool`, `round` and most of `math`. Anything else is a `TranslationError`. Float arithmetic
is that of IEEE 754 and of the C library, operation by operation as Python does it, so that results
are bit-identical; whole numbers have 64 bits. What raises in Python (a division by 0, an index
beyond the end, the root of a negative number) is a fault of the kernel, which machine code does not
look for.
"""

import ast
import inspect
import struct
from collections.abc import Iterator, Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from types import FunctionType
from typing import Any, get_args, get_origin

from achse.native.declare import Layout
from achse.native.expressions import LIBRARY
from achse.native.function import Body
from achse.native.instructions import OURS, TranslationError
from achse.native.kinds import (
    BOOL,
    BYTE,
    INT,
    NOTHING,
    REAL,
    Kind,
    Record,
    Row,
    Scalar,
    Several,
    machine_types,
)

__all__ = ["ENTRY", "TranslationError", "externals", "machine_signature", "translate"]

ENTRY = "entry"
"""Name of the function of the machine code that is called from outside."""


def translate(entry: FunctionType, layouts: Mapping[type, Layout[Any]]) -> str:
    """LLVM assembly of `entry` and all it calls; `layouts` are those of the record classes.

    The machine's parameters of `entry` are its own, one by one, where a sequence is an address and
    a length.
    """
    return _Translation(layouts).run(entry)


def machine_signature(
    entry: FunctionType, layouts: Mapping[type, Layout[Any]]
) -> tuple[list[str], str]:
    """The machine's types of the parameters of `entry` and of its result, "" if there is none."""
    _, kinds, result = _annotated(entry, layouts)
    machines = [machine for kind in kinds for machine in machine_types(kind)]
    results = machine_types(result)
    if len(results) > 1 or "i1" in (*machines, *results):
        raise _error(entry, "takes or gives what cannot be called from outside")
    return machines, "".join(results)


def externals() -> Iterator[tuple[str, str]]:
    """The symbols that machine code expects outside, and the C functions they are."""
    return ((OURS + name, name) for name in LIBRARY.values())


@dataclass
class _Function:
    """A function and how it is called."""

    symbol: str
    names: Sequence[str]
    kinds: Sequence[Kind]
    defaults: Mapping[str, object]
    result: Kind
    source: ast.FunctionDef = field(repr=False)


class _Translation:
    def __init__(self, layouts: Mapping[type, Layout[Any]]) -> None:
        self._layouts = layouts
        self._known: dict[FunctionType, _Function] = {}
        self._waiting: list[FunctionType] = []
        self._sources: dict[str, dict[str, ast.FunctionDef]] = {}
        self._tables: dict[tuple[str, ...], str] = {}
        self._externals: dict[str, int] = {}

    def run(self, entry: FunctionType) -> str:
        outermost = self.signature(entry)
        outermost.symbol = f"@{ENTRY}"
        bodies = []
        while self._waiting:
            function = self._waiting.pop()
            known = self._known[function]
            linkage = "" if function is entry else "internal "
            bodies.append(Body(self, function, known, known.source).text(linkage))
        tables = [
            f"{symbol} = private constant [{len(numbers)} x i64] [{', '.join(numbers)}]"
            for numbers, symbol in self._tables.items()
        ]
        externals = [
            f"declare double {symbol}({', '.join(['double'] * count)}) readnone nounwind"
            for symbol, count in self._externals.items()
        ]
        head = ["declare i64 @llvm.fptosi.sat.i64.f64(double)"]
        return "\n".join([*head, *externals, *tables, *bodies]) + "\n"

    # -- what functions ask for --------------------------------------------------------------

    def signature(self, function: FunctionType) -> _Function:
        """How to call a function, which thereby becomes part of the translation."""
        known = self._known.get(function)
        if known is None:
            known = self._known[function] = self._declare(function)
            self._waiting.append(function)
        return known

    def table(self, numbers: tuple[Any, ...], kind: Scalar) -> str:
        """Address of constant numbers."""
        packed = (struct.pack("<d" if kind is REAL else "<q", number) for number in numbers)
        words = tuple(f"i64 {int.from_bytes(each, 'little')}" for each in packed)
        return self._tables.setdefault(words, f"@table{len(self._tables)}")

    def external(self, symbol: str, count: int) -> None:
        """There is a function outside that makes a float of `count` floats."""
        self._externals[symbol] = count

    def _declare(self, function: FunctionType) -> _Function:
        names, kinds, result = _annotated(function, self._layouts)
        return _Function(
            symbol=f'@"{function.__module__}.{function.__name__}"',
            names=names,
            kinds=kinds,
            defaults={
                parameter.name: parameter.default
                for parameter in inspect.signature(function).parameters.values()
                if parameter.default is not parameter.empty
            },
            result=result,
            source=self._source(function),
        )

    def _source(self, function: FunctionType) -> ast.FunctionDef:
        path = function.__code__.co_filename
        if path not in self._sources:
            tree = ast.parse(Path(path).read_text(encoding="utf-8"), path)
            self._sources[path] = {
                node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)
            }
        source = self._sources[path].get(function.__qualname__)
        if source is None:
            raise _error(function, "is not a function of a module")
        return source


def _annotated(
    function: FunctionType, layouts: Mapping[type, Layout[Any]]
) -> tuple[list[str], list[Kind], Kind]:
    """Names and kinds of the parameters, and the kind of the result."""
    annotations = inspect.get_annotations(function, eval_str=True)
    names = []
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is not parameter.POSITIONAL_OR_KEYWORD:
            raise _error(function, f"parameter {parameter.name}")
        names.append(parameter.name)
    for name in (*names, "return"):
        if name not in annotations:
            raise _error(function, f"{name} has no annotation")
    kinds = [_kind(annotations[name], function, layouts) for name in names]
    return names, kinds, _kind(annotations["return"], function, layouts)


def _kind(annotation: Any, function: FunctionType, layouts: Mapping[type, Layout[Any]]) -> Kind:
    for plain, kind in ((float, REAL), (int, INT), (bool, BOOL), (None, NOTHING)):
        if annotation is plain:
            return kind
    if annotation is bytearray:
        return Row(BYTE)
    if isinstance(annotation, type):
        if annotation in layouts:
            return Record(layouts[annotation])
        if issubclass(annotation, IntEnum):
            return INT
    arguments = get_args(annotation)
    if get_origin(annotation) is tuple and Ellipsis not in arguments:
        return Several(tuple(_kind(part, function, layouts) for part in arguments))
    if get_origin(annotation) in (Sequence, MutableSequence):
        of = _kind(arguments[0], function, layouts)
        if isinstance(of, Record) or of in (REAL, INT):
            return Row(of)
    raise _error(function, f"{annotation!r} is no kind of value of a kernel")


def _error(function: FunctionType, what: str) -> TranslationError:
    code = function.__code__
    return TranslationError(f"{code.co_filename}:{code.co_firstlineno}: {code.co_name}: {what}")
