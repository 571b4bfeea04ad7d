"""Time per executed statement of Structured Text, plain and as machine code, beside a C program.

The body is 100 groups of ten statements: assignments of DINT, INT, WORD, LREAL and BOOL, IF, a
checked array index, MOD, SHL, a conversion that rounds. All forms must end with the same sum.
What a cycle costs without any statement, the turn of the task, is measured first and taken off.
Usage: python benchmarks/st_run.py [GROUPS] [SECONDS]
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from achse.native.backend import compiler_installed
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

STATEMENTS = 10
"""Executed per group, the branch of the IF included."""

HEAD = """PROGRAM MAIN
VAR
    d : DINT; n : INT; w : WORD; f : LREAL; b : BOOL; a : ARRAY[0..99] OF INT; i : INT;
END_VAR
"""
GROUP = """i := {index};
d := d + n * 3;
n := n + 7;
w := SHL(w, 1) XOR d;
f := f * 0.5 + d;
b := d > n;
IF b THEN a[i] := n; ELSE a[i] := n - d; END_IF
d := d MOD 100003;
n := LREAL_TO_INT(f);
"""

C_HEAD = """#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
static struct {
    int32_t d; int16_t n; uint16_t w; double f; uint8_t b; int16_t a[100]; int16_t i;
} m;
static int64_t whole(double x) {
    if (x != x) return 0;
    if (!(x >= -9223372036854775808.0 && x < 9223372036854775808.0)) return INT64_MIN;
    double y = x < 0 ? -x : x;
    int64_t k = (int64_t)y;
    k += y - (double)k >= 0.5;
    return x < 0 ? -k : k;
}
static void cycle(void) {
"""
C_GROUP = """m.i = {index};
m.d = (int32_t)((uint32_t)m.d + (uint32_t)((int32_t)m.n * 3));
m.n = (int16_t)(m.n + 7);
m.w = (uint16_t)((((uint32_t)m.w) << 1) ^ (uint32_t)m.d);
m.f = m.f * 0.5 + m.d;
m.b = m.d > m.n;
if (m.i < 0 || m.i > 99) abort();
if (m.b) m.a[m.i] = m.n; else m.a[m.i] = (int16_t)(m.n - m.d);
m.d = m.d % 100003;
m.n = (int16_t)whole(m.f);
"""
C_TAIL = """}
int main(int argc, char **argv) {
    long cycles = atol(argv[1]);
    struct timespec t0, t1;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t0);
    for (long k = 0; k < cycles; k++) cycle();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t1);
    long sum = m.d + m.n + m.w;
    for (int k = 0; k < 100; k++) sum += m.a[k];
    printf("%.9f %ld\\n", (t1.tv_sec - t0.tv_sec) + (t1.tv_nsec - t0.tv_nsec) * 1e-9, sum);
}
"""


def station(groups: int, form: CodeForm = CodeForm.PLAIN) -> tuple[PlcRuntime, float, float]:
    """The PLC, and how long it took from the text to the first cycle; and of that, the code.

    Python looks for no garbage meanwhile, as when a station starts.
    """
    with collection_paused():
        return _station(groups, form)


def _station(groups: int, form: CodeForm) -> tuple[PlcRuntime, float, float]:
    body = "".join(GROUP.format(index=number % 100) for number in range(groups))
    began = time.process_time()
    project = declare([parse(Source(HEAD + body + "END_PROGRAM\n", "bench.st"), name="GVL")])
    task = Task("PlcTask", 10_000_000, [project.programs["main"]])
    checked = check(project)
    parsed = time.process_time()
    bodies = Bodies(checked, budget=1 << 40, form=form)
    plc = PlcRuntime([task], project.units, bodies=bodies)
    assert plc.failure == "", plc.failure
    ended = time.process_time()
    return plc, ended - began, ended - parsed


def total(plc: PlcRuntime) -> int:
    """The sum that all forms must have."""
    main = plc.instance("MAIN")
    return int(main["d"] + main["n"] + main["w"] + sum(main["a"]))


def measured(plc: PlcRuntime, seconds: float) -> tuple[int, float]:
    """Cycles run, and the processor time of one in seconds."""
    task, cycles, spent = plc.tasks[0], 0, 0.0
    while spent < seconds or cycles < 3:
        began = time.process_time()
        plc.run_due(task.due_ns + 9 * task.cycle_ns)
        spent += time.process_time() - began
        cycles += 10
    assert plc.failure == "", plc.failure
    return cycles, spent / cycles


def in_c(groups: int, cycles: int, option: str) -> tuple[float, int] | None:
    """Processor time of a cycle in C, and the sum; None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    body = "".join(C_GROUP.format(index=number % 100) for number in range(groups))
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder, "bench.c"), Path(folder, "bench")
        source.write_text(C_HEAD + body + C_TAIL)
        flags = [option, "-ffp-contract=off", "-fwrapv"]
        subprocess.run([compiler, *flags, "-o", str(program), str(source)], check=True)
        said = subprocess.run([program, str(cycles)], capture_output=True, text=True, check=True)
    spent, result = said.stdout.split()
    return float(spent) / cycles, int(result)


def _form(
    name: str,
    groups: int,
    form: CodeForm,
    seconds: float,
    expected: tuple[int, int] | None = None,
) -> tuple[PlcRuntime, int]:
    """Make and measure one form; the PLC, and the cycles it has run. `expected`: the sum after a
    number of cycles."""
    statements = groups * STATEMENTS
    plc, all_of_it, compiling = station(groups, form)
    if expected is not None:
        plc.run_due(plc.tasks[0].due_ns + (expected[0] - 1) * plc.tasks[0].cycle_ns)
        assert total(plc) == expected[1], (total(plc), expected[1])
    turn = measured(station(0, form)[0], seconds / 4)[1]
    cycles, of_cycle = measured(plc, seconds)
    of_cycle -= turn
    share = 5000 * of_cycle / statements / 0.01
    print(
        f"{name}{of_cycle / statements * 1e9:9.2f} ns per statement,"
        f" 5,000 of them take {share:.2%} of a 10 ms task;"
        f" an empty cycle {turn * 1e6:.1f} µs;"
        f" from text to first cycle {all_of_it * 1000:.0f} ms, code {compiling * 1000:.0f} ms of it"
    )
    return plc, cycles


def main() -> None:
    groups = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 3.0
    statements = groups * STATEMENTS
    print(f"{statements:,} statements")
    plc, cycles = _form("plain  ", groups, CodeForm.PLAIN, seconds)
    if compiler_installed():
        with tempfile.TemporaryDirectory() as folder:
            os.environ["ACHSE_CACHE_DIR"] = folder
            station(1, CodeForm.MACHINE)  # llvmlite is loaded, our own code hashed
            _form("machine", groups, CodeForm.MACHINE, seconds, (cycles, total(plc)))
            _, _, compiling = station(groups, CodeForm.MACHINE)
            print(f"machine  code of the same from the cache in {compiling * 1000:.0f} ms")
    for option in ("-O0", "-O2"):
        compiled = in_c(groups, cycles, option)
        if compiled is None:
            print(f"cc {option}: no C compiler here")
            continue
        assert compiled[1] == total(plc), (compiled[1], total(plc))
        print(f"cc {option}   {compiled[0] / statements * 1e9:8.2f} ns per statement, the same sum")


if __name__ == "__main__":
    main()
