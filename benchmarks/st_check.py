"""Statements of Structured Text per second from the text to the typed form, on one core.

The programs are made up but hold what programs hold: arithmetic of all kinds, conditions, arrays,
structures, calls of functions and timers. Usage: python benchmarks/st_check.py [STATEMENTS]
"""

import sys
import time

from achse.st.check import check
from achse.st.declare import declare
from achse.st.parser import parse

SHARED = """\
FUNCTION F_Scale : INT
VAR_INPUT
    nValue : INT;
    bHalf : BOOL;
END_VAR
F_Scale := SEL(bHalf, nValue, nValue / 2);
END_FUNCTION

TYPE ST_Point : STRUCT x, y : INT; END_STRUCT END_TYPE
"""

HEAD = """\
PROGRAM P{n}
VAR
    n1, n2 : INT;
    d : DWORD;
    b : BOOL;
    l : LREAL;
    w : WORD;
    a : ARRAY [0..9] OF INT;
    st : ST_Point;
    t : TON;
END_VAR
"""

BODY = """\
n1 := n1 + n2 * 3;
IF b AND n1 > 5 THEN
    l := l * 1.5 + n1;
ELSE
    w := w OR 16#F0;
END_IF
a[n1 MOD 10] := n2;
n2 := a[3] - n1;
d := SHL(d, 2);
st.x := st.y + 1;
n1 := F_Scale(n2, b);
t(IN := b, PT := T#1s);
b := t.Q;
"""
STATEMENTS = 12
"""In one `BODY`."""
BODIES = 100
"""In one program."""


def main() -> None:
    """Print how long each step takes."""
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    programs = max(1, round(wanted / STATEMENTS / BODIES))
    text = SHARED + "".join(
        HEAD.format(n=n) + BODY * BODIES + "END_PROGRAM\n" for n in range(programs)
    )
    count = programs * BODIES * STATEMENTS
    began = time.perf_counter()
    parsed = parse(text).check()
    read = time.perf_counter()
    declared = declare([parsed])
    known = time.perf_counter()
    project = check(declared)
    ended = time.perf_counter()
    if project.faults:
        raise SystemExit(str(project.faults[0]))
    print(f"{count} statements in {programs} programs")
    for name, seconds in (
        ("parse", read - began), ("declare", known - read), ("check", ended - known),
    ):  # fmt: skip
        print(f"{name:8}{seconds * 1e3:8.0f} ms {count / seconds:12,.0f} statements/s")


if __name__ == "__main__":
    main()
