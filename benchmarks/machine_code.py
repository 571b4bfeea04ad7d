"""Machine code of 1,000 statements as Structured Text has them: building, compiling, running.

Assignments of INT, DINT and LREAL, IF, a checked index, shifts and conversions over the bytes of a
PLC's memory, with a budget; each way to compile. Also a call from Python and one back.
Times are those of the processor.
Usage: python benchmarks/machine_code.py [STATEMENTS]
"""

import sys
import time
from collections.abc import Callable
from typing import Any

from achse.native.backend import (
    ADDRESS,
    F64,
    I16,
    I32,
    Effort,
    FunctionBuilder,
    MachineCode,
    ModuleBuilder,
    Operand,
    Relation,
    address_of,
    compile_module,
    compiler_installed,
)

GROUP = 7
"""Statements of one group that are executed."""


def group(code: FunctionBuilder, this: Operand, place: int) -> None:
    """Seven statements on 32 bytes of memory from `place` on."""
    count = code.load(I32, this, place)
    count = code.add(count, code.constant(I32, 7))  # count := count + 7
    code.store(count, this, place)
    small = code.convert(count, I16)  # small := DINT_TO_INT(count)
    code.store(small, this, place + 4)
    shifted = code.shift_left(small, code.constant(I16, 3))  # shifted := SHL(small, 3)
    code.store(shifted, this, place + 6)
    index = code.remainder(code.bit_and(count, code.constant(I32, 0xFF)), code.constant(I32, 4))
    inside = code.compare(Relation.LESS, index, code.constant(I32, 4))
    code.require(inside, 1, index)
    code.store(small, code.address(this, index, 2, within=place + 8))  # field[index] := small
    speed = code.load(F64, this, place + 16)
    speed = code.add(code.multiply(speed, code.constant(F64, 0.5)), code.convert(count, F64))
    code.store(speed, this, place + 16)  # speed := speed * 0.5 + count
    high, low, end = code.label(), code.label(), code.label()
    code.branch(code.compare(Relation.GREATER, speed, code.constant(F64, 100.0)), high, low)
    code.begin(high)  # IF speed > 100 THEN
    code.store(code.constant(I16, 1), this, place + 24)
    code.store(code.constant(F64, 0.0), this, place + 16)
    code.jump(end)
    code.begin(low)  # ELSE
    code.store(code.subtract(code.load(I16, this, place + 24), small), this, place + 24)
    code.begin(end)  # END_IF
    code.spend()


def built(statements: int) -> ModuleBuilder:
    """A module with one function of so many statements, and two for the ways between the worlds."""
    module = ModuleBuilder()
    code = module.function("cycle", [ADDRESS], exported=True, faults=True)
    for number in range(statements // GROUP):
        group(code, code.parameters[0], 32 * number)
    back = module.callback("back", [])
    module.function("nothing", [I32], [I32], exported=True).return_(Operand(I32, "0"))
    calls = module.function("calls", exported=True, faults=True)
    for _ in range(100):
        calls.call(back)
    return module


def each(run: Callable[[], Any], count: int) -> float:
    """Seconds of one run, the best of five times `count`."""
    best = 1e9
    for _ in range(5):
        begin = time.process_time()
        for _ in range(count):
            run()
        best = min(best, (time.process_time() - begin) / count)
    return best


def main() -> None:
    statements = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    if not compiler_installed():
        print("no llvmlite")
        return
    begin = time.process_time()
    module = built(statements)
    text = module.assembly()
    print(f"{statements} statements written in {(time.process_time() - begin) * 1e3:.0f} ms")
    for effort in Effort:
        compile_module(ModuleBuilder(), effort)  # LLVM begins
        begin = time.process_time()
        content = compile_module(text, effort)
        seconds = time.process_time() - begin
        code = MachineCode(content, module.interface, {"back": lambda: None})
        memory = bytearray(32 * statements // GROUP)
        code.budget = 1 << 62
        cycle, place = code.function("cycle"), address_of(memory)
        run = each(lambda cycle=cycle, place=place: cycle(place), 200)  # type: ignore[misc]
        print(
            f"{effort.name:5} compiled in {seconds * 1e3:5.0f} ms, {len(content):7} bytes, "
            f"{run / statements * 1e9:6.2f} ns per statement"
        )
    nothing, calls = code.function("nothing"), code.function("calls")
    print(f"a call from Python {each(lambda: nothing(1), 10_000) * 1e9:.0f} ns")
    print(f"a call back to Python {each(calls, 200) / 100 * 1e9:.0f} ns")


if __name__ == "__main__":
    main()
