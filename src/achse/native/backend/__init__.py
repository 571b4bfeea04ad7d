"""The back end: typed instructions in, machine code of this processor out.

A front end (`achse.native`'s kernels, code of Structured Text) knows a language. The back end knows
none: it has numbers of 8 to 64 bits with and without sign, two floats, bools and addresses
(`I8` … `U64`, `F32`, `F64`, `BOOL`, `ADDRESS`). A `ModuleBuilder` takes functions; a
`FunctionBuilder` writes one of them, instruction by instruction; `compile_module` makes an object
file, which `ObjectCache` keeps; `MachineCode` loads it. A counter in a PLC's memory:

>>> from achse.native.backend import *
>>> module = ModuleBuilder()
>>> report = module.callback("report", [I16])
>>> main = module.function("MAIN", [ADDRESS], exported=True, faults=True)
>>> (this,) = main.parameters
>>> i = main.variable(I16)                             # FOR i := 1 TO 10 DO
>>> main.set(i, main.constant(I16, 1))
>>> again, body, end = main.label(), main.label(), main.label()
>>> main.begin(again)
>>> main.spend()
>>> main.branch(main.compare(Relation.LESS_EQUAL, main.get(i), main.constant(I16, 10)), body, end)
>>> main.begin(body)
>>> total = main.load(I16, this, 3)                    # total : INT at byte 3
>>> main.store(main.add(total, main.get(i)), this, 3)  # total := total + i
>>> main.set(i, main.add(main.get(i), main.constant(I16, 1)))
>>> main.jump(again)
>>> main.begin(end)                                    # END_FOR
>>> _ = main.call(report, main.load(I16, this, 3))
>>> main.return_()

The module becomes code, the code a function of Python; here it runs on a `bytearray`:

>>> seen = []
>>> content = compile_module(module, Effort.FAST)
>>> code = MachineCode(content, module.interface, {"report": seen.append})
>>> cycle = code.function("MAIN")
>>> memory = bytearray(8)
>>> code.budget = 100
>>> cycle(address_of(memory))
>>> cycle(address_of(memory))
>>> seen, int.from_bytes(memory[3:5], "little"), code.budget
([55, 110], 110, 78)

**Control.** Labels: `label` makes one, `begin` puts it, `jump`, `branch` and `switch` (CASE) go to
it. What follows a jump or `return_` without a label is dropped by the compiler, not an error.

**Memory.** `load` and `store` at a base and an offset in bytes, a number or an operand; any
alignment; BOOL is a byte. `address` computes, `copy` (overlapping or not) and `fill` move bytes.
Loads and stores trust the address: check an index with `require` before. `variable` is a local in
a register, `buffer` a piece of the stack.

**Numbers.** Both operands have one type; `convert` cuts, extends by the old type's sign, rounds to
zero and holds floats at the new type's ends. Whole numbers wrap around. `divide` and `remainder`
round to zero and do not trap; a language that faults checks with `require` before. `round` before
`convert` for other roundings.

**Faults and budgets.** A function declared with `faults` may `leave` or `require`: the fault's
number and two values reach Python as `MachineFault`, at once, through all callers. `spend`, at the
head of loops, takes from `MachineCode.budget`; `descend`, at the begin of functions that may call
themselves, ends a recursion before the stack of the thread does (`OwnFault`): it compares the stack
pointer with the limit of that stack. An exception of a callback comes out of the Python call as it
is.

**Calls.** `ModuleBuilder.declare` then `write`, in any order, or `function` for both; several
results are possible inside the module. `function_address` and `call_at` make tables of methods.

**Speed** is in `benchmarks/machine_code.py`: 1,000 statements compile in 40 ms and take 0.7 ns each
with `Effort.FAST`, 200 ms and 0.5 ns with `FULL`.
"""

from achse.native.backend.builder import FunctionBuilder, Label, LocalVariable
from achse.native.backend.cache import ObjectCache
from achse.native.backend.faults import MachineFault, OwnFault
from achse.native.backend.instructions import Instructions, Relation, Rounding
from achse.native.backend.machine import (
    Effort,
    MachineCode,
    address_of,
    compile_module,
    compiler_installed,
    identity,
)
from achse.native.backend.module import ModuleBuilder, ModuleInterface
from achse.native.backend.types import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    CallTarget,
    FunctionSignature,
    InstructionError,
    MachineType,
    Operand,
)

__all__ = [
    "ADDRESS",
    "BOOL",
    "F32",
    "F64",
    "I8",
    "I16",
    "I32",
    "I64",
    "U8",
    "U16",
    "U32",
    "U64",
    "CallTarget",
    "Effort",
    "FunctionBuilder",
    "FunctionSignature",
    "InstructionError",
    "Instructions",
    "Label",
    "LocalVariable",
    "MachineCode",
    "MachineFault",
    "MachineType",
    "ModuleBuilder",
    "ModuleInterface",
    "ObjectCache",
    "Operand",
    "OwnFault",
    "Relation",
    "Rounding",
    "address_of",
    "compile_module",
    "compiler_installed",
    "identity",
]
