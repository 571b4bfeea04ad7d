"""A PLC of one source text: its declarations, its bodies, its runtime; and blocks with a life."""

from achse.plc.bodies import Bodies
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

__all__ = ["LIFE", "bodies_of", "declared_text", "life_text", "plc_of"]

LIFE = """
FUNCTION_BLOCK FB_Inner
VAR nInit : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; nStart : INT; END_VAR
nInit := nStart;
GVL.sLog := CONCAT(GVL.sLog, 'i');
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, 'e');
END_METHOD
METHOD FB_reinit : BOOL
GVL.sLog := CONCAT(GVL.sLog, 'r');
END_METHOD
END_FUNCTION_BLOCK
VAR_GLOBAL sLog : STRING; END_VAR
PROGRAM MAIN
VAR a : FB_Inner(nStart := 7); n : INT; {more} END_VAR
n := n + {step};
END_PROGRAM
"""


def declared_text(text: str) -> Declarations:
    return declare([parse(Source(text, "life.st"), name="GVL")])


def bodies_of(declared: Declarations) -> Bodies:
    typed = check(declared)
    assert not typed.faults, "\n".join(map(str, typed.faults))
    return Bodies(typed)


def plc_of(text: str) -> PlcRuntime:
    declared = declared_text(text)
    main = declared.programs["main"]
    task = Task("PlcTask", 10_000_000, [main])
    return PlcRuntime([task], declared.units, bodies=bodies_of(declared))


def life_text(step: int = 1, more: str = "") -> str:
    return LIFE.replace("{step}", str(step)).replace("{more}", more)
