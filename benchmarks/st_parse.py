"""Lines of Structured Text per second through lexer and parser, on one core.

The sources are made up but look like an application's: data types, variable lists, function
blocks with methods, comments, blank lines. Usage: python benchmarks/st_parse.py [LINES]
"""

import sys
import time

from achse.st.lexis.lexer import scan
from achse.st.syntax.parser import parse

TYPES = """\
{{attribute 'qualified_only'}}
{{attribute 'strict'}}
TYPE E_State{n} :
(
    Idle := 0,      // waits for the release
    Homing := 10,
    Running := 20,
    Error := 99     // see nErrorId
) UINT;
END_TYPE

TYPE ST_Recipe{n} :
STRUCT
    sName : STRING(80);                             // shown on the panel
    aPositions : ARRAY [1..10, 0..3] OF LREAL;
    eState : E_State{n} := E_State{n}.Idle;
    tDelay : TIME := T#1m30s;
    bActive, bLocked : BOOL;
    stLimits : ST_Limits := (fLow := -10.5, fHigh := 1.5E3);
END_STRUCT
END_TYPE

"""

BLOCK = """\
// Moves one valve and watches its end positions.
FUNCTION_BLOCK FB_Valve{n} EXTENDS FB_Base IMPLEMENTS I_Valve
VAR_INPUT
    bOpen : BOOL;               // command
    bEnable : BOOL := TRUE;
    fPressure : LREAL;
    tTimeout : TIME := T#2s500ms;
END_VAR
VAR_OUTPUT
    bIsOpen : BOOL;
    bError : BOOL;
    nErrorId : UDINT;
END_VAR
VAR
    fbTimer : TON;
    fbEdge : R_TRIG;
    {{attribute 'hide'}}
    nStep : INT;
    aHistory : ARRAY [0..cMaxHistory - 1] OF ST_Sample;
    bLimit AT %I* : BOOL;
    i : DINT;
END_VAR

fbEdge(CLK := bOpen);
fbTimer(IN := nStep <> 0, PT := tTimeout);

(* the steps of the valve,
   one after the other *)
CASE nStep OF
    0:
        IF fbEdge.Q AND bEnable THEN
            nStep := 10;
            bError := FALSE;
        END_IF

    10, 11:
        IF bLimit THEN
            bIsOpen := TRUE;
            nStep := 20;
        ELSIF fbTimer.Q OR_ELSE fPressure > 6.5 THEN
            nErrorId := 16#8000_0001;
            nStep := 99;
        END_IF

    20..29:
        FOR i := 0 TO cMaxHistory - 1 BY 1 DO
            aHistory[i].fValue := aHistory[i].fValue * 0.9 + fPressure / 10.0;
            IF ABS(aHistory[i].fValue) > GVL.fLimit THEN
                EXIT;
            END_IF
        END_FOR
        nStep := SEL(bOpen, 0, nStep + 1);
    ELSE
        bError := TRUE;
END_CASE

METHOD PUBLIC Reset : BOOL
VAR_INPUT
    bHard : BOOL;
END_VAR
    THIS^.nStep := 0;
    bError := NOT bHard AND (nErrorId <> 0);
    stStatus.nWord.3 := bError;
    Reset := LogMessage(sText := CONCAT('valve $'{n}$'', TO_STRING(nErrorId)), bDone => bIsOpen);
END_METHOD

END_FUNCTION_BLOCK

"""

GLOBALS = """\
VAR_GLOBAL
    // drive {n}
    stDrive{n} : ST_Drive := (nId := {n}, fScale := 0.001, aOffsets := [1, 2, 3(0)]);
    bRelease{n} AT %IX{n}.0 : BOOL;
    fSpeed{n} : LREAL := 2 * cSpeed / 60;
    pData{n} : POINTER TO BYTE;
END_VAR

"""


def sources(lines: int) -> list[str]:
    """Texts of together at least that many lines, each about as long as a usual file."""
    texts = []
    count = number = 0
    while count < lines:
        number += 1
        text = "".join(part.format(n=number) for part in (TYPES, BLOCK, GLOBALS))
        count += text.count("\n")
        texts.append(text)
    return texts


def main() -> None:
    texts = sources(int(sys.argv[1]) if len(sys.argv) > 1 else 50_000)
    lines = sum(text.count("\n") for text in texts)
    signs = sum(map(len, texts))
    best_scan = best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        tokens = sum(len(scan(text).kinds) for text in texts)
        best_scan = min(best_scan, time.perf_counter() - start)
        start = time.perf_counter()
        faults = [fault for text in texts for fault in parse(text).faults]
        best = min(best, time.perf_counter() - start)
        if faults:
            sys.exit(str(faults[0]))
    print(f"{lines} lines, {signs} characters, {tokens} tokens in {len(texts)} files")
    print(f"lexer   {lines / best_scan:>9,.0f} lines/s")
    print(f"whole   {lines / best:>9,.0f} lines/s")


if __name__ == "__main__":
    main()
