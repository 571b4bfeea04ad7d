"""A module of machine code while it is written: its functions, constant data and ways out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from achse.native.backend.builder import FunctionBuilder
from achse.native.backend.faults import NOTES, RUNTIME
from achse.native.backend.stack_checks import STACK_RUNTIME, measuring
from achse.native.backend.types import (
    ADDRESS,
    EMPTY_NOTE,
    F64,
    CallTarget,
    FunctionSignature,
    InstructionError,
    MachineType,
    Operand,
)

_CALLS = """!llvm.module.flags = !{!1}
!1 = !{i32 7, !"RtLibUseGOT", i32 1}
"""
"""Calls outside that LLVM makes itself go by a table of addresses, as `nonlazybind` says."""

C_PREFIX = "achse_"
"""C functions get names of their own, so that LLVM does not know better what they give."""


MATH = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cosh", "cos", "erf", "exp"),
    *("expm1", "fmod", "log10", "log1p", "log", "pow", "sin", "sinh", "tan", "tanh"),
)
"""Functions of floats in the C library, one or two of them to one."""

C_FUNCTIONS = (*MATH, "memcmp", "strlen", "strcmp", "strncmp")
"""Functions of the C library that a module may call."""


@dataclass(frozen=True, slots=True)
class ModuleInterface:
    """Interface of a module to Python; enough to load its machine code."""

    functions: Mapping[str, CallTarget] = field(default_factory=dict)
    callbacks: Mapping[str, FunctionSignature] = field(default_factory=dict)
    words: Mapping[str, int] = field(default_factory=dict)


class ModuleBuilder:
    """Functions by name, written one after the other; `assembly` is all of them as LLVM text."""

    def __init__(self) -> None:
        self._functions: dict[str, CallTarget] = {}
        self._exported: dict[str, CallTarget] = {}
        self._callbacks: dict[str, CallTarget] = {}
        self._declared: dict[str, str] = {}
        self._data: dict[bytes, str] = {}
        self._words: dict[str, int] = {}
        self._tables: dict[str, Sequence[CallTarget | None]] = {}
        self._bodies: list[FunctionBuilder] = []
        self.notes = b""
        """Bytes that go with the machine code into the cache: what its fault numbers mean."""

    @property
    def interface(self) -> ModuleInterface:
        callbacks = {name: callback.signature for name, callback in self._callbacks.items()}
        return ModuleInterface(dict(self._exported), callbacks, dict(self._words))

    # -- what can be called ------------------------------------------------------------------

    def declare(
        self,
        name: str,
        parameters: Sequence[MachineType] = (),
        results: Sequence[MachineType] = (),
        *,
        exported: bool = False,
        faults: bool = False,
    ) -> CallTarget:
        """Return a function of this module, to be called before it is written.

        `exported` ones can be called from Python and have at most one result. `faults` says that
        the function, or one that it calls, may leave with a fault.
        """
        if name in self._functions:
            raise InstructionError(f"function {name!r} is declared twice")
        signature = FunctionSignature(tuple(parameters), tuple(results))
        function = CallTarget(f'@"{name}"', signature, faults, convention=exported)
        self._functions[name] = function
        if exported:
            signature.c_types  # noqa: B018  refuses what Python cannot call
            self._exported[name] = function
        return function

    def write(self, function: CallTarget, names: Sequence[str] = ()) -> FunctionBuilder:
        """Return the body of a declared function, to be filled; `names` are for the assembly
        text."""
        body = FunctionBuilder(self, function, names, self._is_exported(function))
        self._bodies.append(body)
        return body

    def function(
        self,
        name: str,
        parameters: Sequence[MachineType] = (),
        results: Sequence[MachineType] = (),
        *,
        exported: bool = False,
        faults: bool = False,
    ) -> FunctionBuilder:
        """Declare a function and begin with its body."""
        return self.write(self.declare(name, parameters, results, exported=exported, faults=faults))

    def callback(
        self, name: str, parameters: Sequence[MachineType], results: Sequence[MachineType] = ()
    ) -> CallTarget:
        """Return a function of Python; what it raises ends the machine code and reaches its
        caller."""
        signature = FunctionSignature(tuple(parameters), tuple(results))
        known = self._callbacks.get(name)
        if known is None:
            symbol = f'@"callback.{name}"'
            known = CallTarget(symbol, signature, faults=True, pointer=True, convention=True)
            self._callbacks[name] = known
        if known.signature != signature:
            raise InstructionError(f"callback {name!r} is {known.signature}, got {signature}")
        return known

    def c_function(
        self, name: str, parameters: Sequence[MachineType] = (F64,), result: MachineType = F64
    ) -> CallTarget:
        """One of `C_FUNCTIONS`, by default from a float to a float."""
        if name not in C_FUNCTIONS:
            raise InstructionError(f"no C function {name!r}, only {', '.join(C_FUNCTIONS)}")
        signature = FunctionSignature(tuple(parameters), (result,))
        function = CallTarget(f"@{C_PREFIX}{name}", signature, convention=True)
        pure = all(each.is_real for each in (*parameters, result))
        self.external(function, ("readnone " if pure else "") + "nounwind nonlazybind")
        return function

    def external(self, function: CallTarget, attributes: str = "") -> None:
        """Declare a function outside the module with this symbol."""
        signature = function.signature
        parameters = ", ".join(each.llvm for each in signature.parameters)
        text = f"declare {signature.llvm_result} {function.symbol}({parameters}) {attributes}"
        self._declared[function.symbol] = text.rstrip()

    # -- data --------------------------------------------------------------------------------

    def data(self, content: bytes) -> Operand:
        """Return the address of constant bytes; it is a multiple of 8."""
        return Operand(ADDRESS, self._data.setdefault(content, f"@data{len(self._data)}"))

    def words(self, name: str, count: int) -> Operand:
        """Return the address of words of 64 bits that the host reads and writes; they begin as
        0."""
        self._words[name] = count
        return Operand(ADDRESS, f'@"words.{name}"')

    def table(self, name: str, functions: Sequence[CallTarget | None]) -> Operand:
        """Return the address of a list of functions, 8 bytes each; None is 0. The host can read
        it."""
        self._tables[name] = functions
        return Operand(ADDRESS, f'@"table.{name}"')

    # -- the text ----------------------------------------------------------------------------

    def assembly(self) -> str:
        """Return the whole module as LLVM assembly; InstructionError if a function was never
        written."""
        written = {body.function.symbol for body in self._bodies}
        for name, function in self._functions.items():
            if function.symbol not in written:
                raise InstructionError(f"function {name!r} is declared but was not written")
        checked = any(body.descends for body in self._bodies)
        bodies = [body.text(checked=checked) for body in self._bodies]
        guards = [body.guard for body in self._bodies]
        data = [
            f"{symbol} = private constant {_characters(content)}, align 8"
            for content, symbol in self._data.items()
        ]
        pointers = [
            f"{callback.symbol} = dso_local global ptr null"
            for callback in self._callbacks.values()
        ]
        words = [
            f'@"words.{name}" = dso_local global [{count} x i64] zeroinitializer'
            for name, count in self._words.items()
        ]
        tables = [
            f'@"table.{name}" = dso_local constant'
            f" [{len(functions)} x ptr] [{_pointers(functions)}]"
            for name, functions in self._tables.items()
        ]
        used = [*self._declared.values(), *data, *pointers, *words, *tables]
        if self._callbacks or any(function.faults for function in self._functions.values()):
            used += [RUNTIME, STACK_RUNTIME]
        if any(guards):
            used.append(measuring([guard for guard in guards if guard is not None]))
        if self.notes:
            used.append(f"{NOTES} = dso_local constant {_characters(_counted(self.notes))}")
        return "\n".join([*used, *bodies, f"{EMPTY_NOTE} = !{{}}", _CALLS])

    def _is_exported(self, function: CallTarget) -> bool:
        return function in self._exported.values()


def _pointers(functions: Sequence[CallTarget | None]) -> str:
    return ", ".join(f"ptr {each.symbol if each else 'null'}" for each in functions)


def _counted(content: bytes) -> bytes:
    return len(content).to_bytes(8, "little") + content


def _characters(content: bytes) -> str:
    text = "".join(map(_ESCAPED.__getitem__, content))
    return f'[{len(content)} x i8] c"{text}"'


_ESCAPED = [f"\\{byte:02X}" for byte in range(256)]
