"""A kernel's functions as a module of machine code: typed plain Python in, the same arithmetic out.

A kernel is functions on records whose parameters and results are annotated. `translate` starts at
one of them and takes in whatever it calls. What a function refers to beyond its own names (numbers,
tuples of numbers, enumerations, functions) is looked up in its module as it is now.

The language: assignments, also to several names; `if`, `while`, `for … in range(…)`, `for row in
TABLE` (a tuple of the module, whose rows may hold numbers and functions), `break`, `continue`,
`return`; numbers, comparisons, `and`, `or`, `not`, `in` a tuple; fields, records that fields refer
to or hold, elements of sequences and of a `bytearray`; `abs`, `min`, `max`, `len`, `int`, `float`,
`bool`, `round` and most of `math`. Anything else is a `TranslationError`. Float arithmetic is that
of IEEE 754 and of the C library, operation by operation as Python does it, so that results are
bit-identical; whole numbers have 64 bits. What raises in Python (a division by 0, an index beyond
the end, the root of a negative number) is a fault of the kernel, which only checked machine code
looks for.

Records without references are values: `assign` copies one, `reset` gives it the values of a fresh
one (`achse.native.declare`). `LAYOUT.plain()` makes a record of the function's own, one for each
place in the source; it ends with the function, which cannot return it.

A call that gives a parameter as `True` or `False` calls a copy of the function for it. So a
function says what is left out on a shorter way, and machine code of that way has nothing of it.

A parameter whose class has only annotations of sequences stands for tables: `rows.encoders[n]` is a
record of the sequence `encoders`. Tables are handed on from function to function; the machine gets
their addresses and lengths.
"""

import ast
import inspect
import struct
from collections.abc import Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from importlib.util import decode_source
from pathlib import Path
from types import FunctionType
from typing import Any, get_args, get_origin

from achse.native.backend.module import ModuleBuilder, ModuleInterface
from achse.native.backend.types import (
    ADDRESS,
    CallTarget,
    FunctionSignature,
    InstructionError,
    Operand,
)
from achse.native.declare import RecordLayout, pack
from achse.native.kernels.arithmetic import TranslationError, Ways
from achse.native.kernels.kinds import (
    BOOL,
    BYTE,
    INT,
    NOTHING,
    REAL,
    RecordReference,
    Row,
    RowTables,
    Scalar,
    Several,
    ValueKind,
    machine_types,
)
from achse.native.kernels.sites import Sites, TrapSite
from achse.native.kernels.statements import FunctionCompiler

ENTRY = "entry"
"""Name of the function of the machine code that is called from outside."""

BOUND = "bound"
"""Name of the function that takes the arguments of `ENTRY` from a block of words in memory."""


def translate(
    entry: FunctionType, layouts: Mapping[type, RecordLayout[Any]], *, checked: bool = False
) -> ModuleBuilder:
    """Return a module with `entry` and all it calls; `layouts` are those of the record classes.

    The machine's parameters of `entry` are its own, one by one, where a sequence is an address and
    a length. A `checked` module leaves where Python raises; its notes are the `Sites`.
    """
    return _Translation(layouts, checked).run(entry)


def interface_of(
    entry: FunctionType, layouts: Mapping[type, RecordLayout[Any]], *, checked: bool = False
) -> ModuleInterface:
    """Return the interface of the machine code of `entry`; TranslationError if Python cannot call
    it.
    """
    _, kinds, result = _annotated(entry, layouts)
    parameters = tuple(machine for kind in kinds for machine in machine_types(kind))
    signature = FunctionSignature(parameters, machine_types(result))
    try:
        signature.c_types  # noqa: B018
    except InstructionError as error:
        raise _error(entry, f"cannot be called from outside: {error}") from None
    targets = {
        name: CallTarget(f'@"{name}"', each, checked, convention=True)
        for name, each in (
            (ENTRY, signature),
            (BOUND, FunctionSignature((ADDRESS,), signature.results)),
        )
    }
    return ModuleInterface(targets)


@dataclass
class _Function:
    """A function and how it is called."""

    machine: CallTarget
    names: Sequence[str]
    kinds: Sequence[ValueKind]
    defaults: dict[str, object]
    result: ValueKind
    ways: Ways
    source: ast.FunctionDef = field(repr=False)


class _Translation:
    def __init__(self, layouts: Mapping[type, RecordLayout[Any]], checked: bool) -> None:
        self.checked = checked
        self._layouts = layouts
        self._module = ModuleBuilder()
        self._functions: dict[tuple[FunctionType, Ways], _Function] = {}
        self._waiting: list[tuple[FunctionType, Ways]] = []
        self._sources: dict[str, dict[str, ast.FunctionDef]] = {}
        self._sites = Sites()
        self._entry: FunctionType | None = None

    def run(self, entry: FunctionType) -> ModuleBuilder:
        interface_of(entry, self._layouts)
        self._entry = entry
        self.callee(entry)
        while self._waiting:
            function, ways = self._waiting.pop()
            known = self._functions[function, ways]
            names = [
                f"{name}.{n}"
                for name, kind in zip(known.names, known.kinds, strict=True)
                for n in range(len(machine_types(kind)))
            ]
            code = self._module.write(known.machine, names)
            FunctionCompiler(self, function, known, known.source, code).write()
        self._bind(self._functions[entry, ()].machine)
        if self.checked:
            self._module.notes = self._sites.pack()
        return self._module

    def _bind(self, entry: CallTarget) -> None:
        """Write the function that takes the arguments of the entry from a block."""
        code = self._module.function(
            BOUND, [ADDRESS], entry.signature.results, exported=True, faults=self.checked
        )
        (block,) = code.parameters
        arguments = [
            code.load(kind, block, 8 * n, aligned=True)
            for n, kind in enumerate(entry.signature.parameters)
        ]
        code.return_(*code.call(entry, *arguments))

    # -- requests of functions ----------------------------------------------------------------

    def callee(self, function: FunctionType, ways: Ways = ()) -> _Function:
        """Return the target for calls of a function, which becomes part of the translation.

        Each of its ways is a copy of its own: the compiler leaves out there what is never done.
        """
        known = self._functions.get((function, ways))
        if known is None:
            known = self._functions[function, ways] = self._declare(function, ways)
            self._waiting.append((function, ways))
        return known

    def table(self, numbers: tuple[Any, ...], kind: Scalar) -> Operand:
        """Address of constant numbers."""
        form = struct.Struct(f"<{len(numbers)}{'d' if kind is REAL else 'q'}")
        return self._module.data(form.pack(*numbers))

    def fresh(self, layout: RecordLayout[Any]) -> Operand:
        """Address of a record with the values of a fresh one."""
        return self._module.data(pack(layout, layout.plain()))

    def site(self, error: type[Exception], text: str, function: FunctionType, line: int) -> int:
        """Return the number of the fault that stands for an exception raised in a line."""
        code = function.__code__
        return self._sites.number(
            TrapSite(error.__name__, text, code.co_filename, line, code.co_name)
        )

    def _declare(self, function: FunctionType, ways: Ways) -> _Function:
        names, kinds, result = _annotated(function, self._layouts)
        outermost = function is self._entry
        chosen = [name if way else f"not_{name}" for name, way in ways]
        machine = self._module.declare(
            ENTRY if outermost else ".".join((function.__module__, function.__name__, *chosen)),
            [machine for kind in kinds for machine in machine_types(kind)],
            machine_types(result),
            exported=outermost,
            faults=self.checked,
        )
        return _Function(
            machine=machine,
            names=names,
            kinds=kinds,
            defaults={
                parameter.name: parameter.default
                for parameter in inspect.signature(function).parameters.values()
                if parameter.default is not parameter.empty
            },
            result=result,
            ways=ways,
            source=self._source(function),
        )

    def _source(self, function: FunctionType) -> ast.FunctionDef:
        path = function.__code__.co_filename
        if path not in self._sources:
            tree = ast.parse(source_of(function), path)
            self._sources[path] = {
                node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)
            }
        source = self._sources[path].get(function.__qualname__)
        if source is None:
            raise _error(function, "is not a function of a module")
        return source


def source_of(function: FunctionType) -> str:
    """Return the text of the module of a function, also from a zip; TranslationError without
    sources."""
    path = Path(function.__code__.co_filename)
    try:
        return decode_source(path.read_bytes())
    except OSError:
        loader = function.__globals__.get("__loader__")
        load = getattr(loader, "get_source", None)
        try:
            text = load(function.__module__) if load else None
        except (OSError, ImportError):
            text = None
        if text is None:
            raise _error(function, "its source is not there") from None
        return str(text)


_SEQUENCES: tuple[object, ...] = Sequence, MutableSequence


def _annotated(
    function: FunctionType, layouts: Mapping[type, RecordLayout[Any]]
) -> tuple[list[str], list[ValueKind], ValueKind]:
    """Return names and kinds of the parameters, and the kind of the result."""
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


def _kind(
    annotation: Any, function: FunctionType, layouts: Mapping[type, RecordLayout[Any]]
) -> ValueKind:
    for plain, kind in ((float, REAL), (int, INT), (bool, BOOL), (None, NOTHING)):
        if annotation is plain:
            return kind
    if annotation is bytearray:
        return Row(BYTE)
    if isinstance(annotation, type):
        if annotation in layouts:
            return RecordReference(layouts[annotation])
        if issubclass(annotation, IntEnum):
            return INT
        rows = inspect.get_annotations(annotation, eval_str=True)
        if rows and all(get_origin(row) in _SEQUENCES for row in rows.values()):
            kinds = (_kind(row, function, layouts) for row in rows.values())
            return RowTables(annotation.__name__, tuple(zip(rows, kinds, strict=True)))
    arguments = get_args(annotation)
    if get_origin(annotation) is tuple and Ellipsis not in arguments:
        return Several(tuple(_kind(part, function, layouts) for part in arguments))
    if get_origin(annotation) in _SEQUENCES:
        of = _kind(arguments[0], function, layouts)
        if isinstance(of, RecordReference) or of in (REAL, INT):
            return Row(of)
    raise _error(function, f"{annotation!r} is not a kind of value of a kernel")


def _error(function: FunctionType, what: str) -> TranslationError:
    code = function.__code__
    return TranslationError(f"{code.co_filename}:{code.co_firstlineno}: {code.co_name}: {what}")
