"""Types of the machine: what an operand of an instruction is."""

import ctypes
from dataclasses import dataclass
from typing import Any


class InstructionError(TypeError):
    """An instruction does not fit its operands; the text says what was expected and what came."""


EMPTY_NOTE = "!0"
"""The metadata without content that ends each module: all that some marks need."""


@dataclass(frozen=True, slots=True, eq=False)
class MachineType:
    """A type: its name, how LLVM writes it, its size, and what its bits mean."""

    name: str
    llvm: str
    bits: int
    """In a register; BOOL fills a whole byte in memory."""
    c_type: Any
    """The ctypes type that carries it between Python and machine code."""
    signed: bool = False
    is_real: bool = False

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return (self.bits + 7) // 8

    @property
    def is_whole(self) -> bool:
        """True if it is a whole number: neither float, bool nor address."""
        return not self.is_real and self is not BOOL and self is not ADDRESS

    @property
    def least(self) -> int:
        """The smallest whole number."""
        return -(1 << self.bits - 1) if self.signed else 0

    @property
    def most(self) -> int:
        """The largest whole number."""
        return (1 << self.bits - self.signed) - 1

    @property
    def extension(self) -> str:
        """Extension of a narrow number to a register of the C calling convention."""
        if self.is_real or self.bits >= 32:
            return ""
        return "signext " if self.signed else "zeroext "

    def __repr__(self) -> str:
        return self.name


BOOL = MachineType("bool", "i1", 1, ctypes.c_bool)
I8 = MachineType("i8", "i8", 8, ctypes.c_int8, signed=True)
U8 = MachineType("u8", "i8", 8, ctypes.c_uint8)
I16 = MachineType("i16", "i16", 16, ctypes.c_int16, signed=True)
U16 = MachineType("u16", "i16", 16, ctypes.c_uint16)
I32 = MachineType("i32", "i32", 32, ctypes.c_int32, signed=True)
U32 = MachineType("u32", "i32", 32, ctypes.c_uint32)
I64 = MachineType("i64", "i64", 64, ctypes.c_int64, signed=True)
U64 = MachineType("u64", "i64", 64, ctypes.c_uint64)
F32 = MachineType("f32", "float", 32, ctypes.c_float, is_real=True)
F64 = MachineType("f64", "double", 64, ctypes.c_double, is_real=True)
ADDRESS = MachineType("address", "ptr", 64, ctypes.c_void_p)
"""Of a byte in this process."""


@dataclass(slots=True, unsafe_hash=True)
class Operand:
    """A value in a function that is being written: its type and its name there.

    It never changes; it is not frozen because that makes it three times as slow to make.
    """

    type: MachineType
    text: str

    @property
    def typed(self) -> str:
        """As LLVM writes it in a list of arguments."""
        return f"{self.type.llvm} {self.text}"

    @property
    def is_constant(self) -> bool:
        """True if it is a number that is known while the function is written."""
        return self.text[0] not in "%@"


@dataclass(frozen=True, slots=True)
class FunctionSignature:
    """Parameters and results of a function; more than one result only between machine functions."""

    parameters: tuple[MachineType, ...] = ()
    results: tuple[MachineType, ...] = ()

    @property
    def llvm_result(self) -> str:
        """The results as one LLVM type."""
        if len(self.results) == 1:
            return self.results[0].llvm
        parts = ", ".join(each.llvm for each in self.results)
        return f"{{ {parts} }}" if parts else "void"

    @property
    def c_types(self) -> tuple[Any, ...]:
        """Result and parameters for ctypes; InstructionError if there are several results."""
        if len(self.results) > 1:
            raise InstructionError(f"one result expected towards Python, got {self.results}")
        result = self.results[0].c_type if self.results else None
        return (result, *(each.c_type for each in self.parameters))


@dataclass(frozen=True, slots=True)
class CallTarget:
    """Target of a call: a function of the module, of Python or of the C library."""

    symbol: str
    signature: FunctionSignature
    faults: bool = False
    """True if a call may end with a fault, which the caller then passes on."""
    pointer: bool = False
    """True if `symbol` is a place that holds the address."""
    convention: bool = False
    """True if it keeps to the C calling convention."""
