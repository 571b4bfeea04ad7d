"""Works of the PLC's language, of part programs."""

from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from typing import Any

Call = Callable[[], object]

STATEMENTS = """i := {index};
d := d + n * 3;
n := n + 7;
w := SHL(w, 1) XOR d;
f := f * 0.5 + d;
b := d > n;
IF b THEN a[i] := n; ELSE a[i] := n - d; END_IF
d := d MOD 100003;
n := LREAL_TO_INT(f);
"""
"""Ten statements, the branch of the IF included."""
VARIABLES = """PROGRAM MAIN
VAR
    d : DINT; n : INT; w : WORD; f : LREAL; b : BOOL; a : ARRAY[0..99] OF INT; i : INT;
END_VAR
"""

LOOPS = """FOR i := 0 TO 19 DO
    a[i] := n;
    IF a[i] > d THEN
        n := n + 1;
    ELSE
        n := n - 3;
    END_IF
    a[i + 1] := a[i] + n;
    CASE n MOD 3 OF
    0: d := d + a[i];
    1: d := d - 7;
    END_CASE
    WHILE d > 100 DO
        d := d / 2 - a[i + 2] MOD 3;
        n := n + 1;
    END_WHILE
END_FOR
"""
"""Blocks of one short statement or two, many of which may fail."""

BLOCKS = """PROGRAM MAIN
VAR
    axes : ARRAY [1..4] OF AXIS_REF;
    power : ARRAY [1..4] OF MC_Power;
    move : ARRAY [1..4] OF MC_MoveAbsolute;
    halt : ARRAY [1..4] OF MC_Halt;
    reset : ARRAY [1..4] OF MC_Reset;
    status : ARRAY [1..4] OF MC_ReadStatus;
    n : INT;
END_VAR
FOR n := 1 TO 4 DO
    power[n](Axis := axes[n], Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
    status[n](Axis := axes[n], Enable := TRUE);
    reset[n](Axis := axes[n], Execute := axes[n].NcToPlc.StateDWord.Error);
    halt[n](Axis := axes[n], Execute := FALSE);
    move[n](Axis := axes[n], Execute := power[n].Status, Position := 1000000.0, Velocity := 100.0);
END_FOR
END_PROGRAM
"""

CHECKED = (
    """FUNCTION F_Scale : INT
VAR_INPUT
    nValue : INT;
    bHalf : BOOL;
END_VAR
F_Scale := SEL(bHalf, nValue, nValue / 2);
END_FUNCTION

TYPE ST_Point : STRUCT x, y : INT; END_STRUCT END_TYPE

PROGRAM MAIN
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
    + 10
    * """n1 := n1 + n2 * 3;
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
    + "END_PROGRAM\n"
)


def _cycles(
    groups: int, form: str, *, counts: bool = False, text: str = STATEMENTS, **options: Any
) -> Call:
    """Return a cycle of a PLC that executes so many times ten statements, with counters or not."""
    from achse.plc.bodies import Bodies
    from achse.plc.code.execution import CodeForm
    from achse.plc.runtime import PlcRuntime
    from achse.plc.task import Task
    from achse.st.check import check
    from achse.st.declare import declare
    from achse.st.lexis.source import Source
    from achse.st.syntax.parser import parse

    body = "".join(text.format(index=number % 100) for number in range(groups))
    project = declare([parse(Source(VARIABLES + body + "END_PROGRAM\n", "a.st"), name="GVL")])
    task = Task("PlcTask", 10_000_000, [project.programs["main"]])
    if counts:
        options["covered"] = lambda _: True
    bodies = Bodies(check(project), budget=1 << 40, form=CodeForm[form], **options)
    plc = PlcRuntime([task], project.units, bodies=bodies)
    assert plc.failure == "", plc.failure

    def cycle() -> None:
        plc.run_due(task.due_ns)

    task = plc.tasks[0]
    for _ in range(50):
        cycle()
    return cycle


def plain() -> Call:
    """Set up 100 statements as plain Python."""
    return _cycles(10, "PLAIN")


def machine() -> Call:
    """Set up 1,000 statements as machine code."""
    return _cycles(100, "MACHINE")


def plain_counted() -> Call:
    """Set up 100 statements as plain Python that count for coverage."""
    return _cycles(10, "PLAIN", counts=True)


def machine_counted() -> Call:
    """Set up 1,000 statements as machine code that count for coverage."""
    return _cycles(100, "MACHINE", counts=True)


def plain_loops() -> Call:
    """Set up loops of tiny blocks as plain Python."""
    return _cycles(1, "PLAIN", text=LOOPS)


def plain_loops_counted() -> Call:
    """Set up loops of tiny blocks as plain Python that count for coverage."""
    return _cycles(1, "PLAIN", counts=True, text=LOOPS)


def loops() -> Call:
    """Set up loops of tiny blocks as machine code."""
    return _cycles(10, "MACHINE", text=LOOPS)


def loops_counted() -> Call:
    """Set up loops of tiny blocks as machine code that count for coverage."""
    return _cycles(10, "MACHINE", counts=True, text=LOOPS)


def loops_with_conditions() -> Call:
    """Set up loops of tiny blocks as machine code that count conditions, too."""
    return _cycles(10, "MACHINE", counts=True, text=LOOPS, conditions=True)


def blocks() -> Call:
    """Set up a station whose PLC moves 4 axes by blocks every 2 ms."""
    from achse.station import Station
    from achse.station.configuration.station_file import parse

    Path("blocks").mkdir(exist_ok=True)
    Path("blocks/a.st").write_text(BLOCKS, encoding="utf-8")
    document: dict[str, Any] = {
        "axis": [{"id": n, "name": f"A{n}", "plc": f"MAIN.axes[{n}]"} for n in range(1, 5)],
        "plc": [{"sources": "a.st", "task": [{"cycle": "2 ms", "programs": ["MAIN"]}]}],
    }
    station = Station(parse(document, "a.toml"), base=Path("blocks"))
    station.advance(3.0)
    assert station.plcs[851].failure == ""
    return lambda: station.advance(0.002)


def part_program() -> Call:
    """Set up a part program of short lines."""
    from achse.gcode.interpretation.interpreter import Interpreter
    from achse.gcode.text.program import PartProgram

    lines = ["G90 G17 G1 F10000"]
    lines += [
        f"N{n} X{20 * sin(0.01 * n):.5f} Y{20 * cos(0.01 * n):.5f} Z{0.1 * n:.5f}"
        for n in range(1, 100)
    ]
    text = "\n".join([*lines, "M30"])

    def interpret() -> None:
        for _ in Interpreter(PartProgram(text)):
            pass

    return interpret


def check_sources() -> Call:
    """Set up sources of 120 statements."""
    from achse.st.check import check
    from achse.st.declare import declare
    from achse.st.syntax.parser import parse

    def run() -> None:
        project = check(declare([parse(CHECKED).check()]))
        assert not project.faults, project.faults

    return run
