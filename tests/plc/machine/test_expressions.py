"""Random programs: machine code leaves the bytes that plain code leaves."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.code.execution import CodeForm

Run = Callable[..., Any]

WHOLES = ("SINT", "USINT", "BYTE", "INT", "UINT", "WORD", "DINT", "UDINT", "DWORD", "LINT", "ULINT",
          "LWORD")  # fmt: skip
REALS = ("REAL", "LREAL")
TIMES = ("TIME", "LTIME", "DATE", "TOD", "DT")
TEXTS = ("STRING(7)", "STRING", "WSTRING(5)")


class Author:
    """Writes a program."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)
        self.depth = 0
        self.loops = 0

    def whole(self, deep: int = 3) -> str:
        """An integer."""
        dice = self.dice
        if deep == 0 or dice.random() < 0.2:
            return dice.choice(
                [f"v{dice.choice(WHOLES)}", f"a{dice.choice(WHOLES)}[i]", str(dice.randint(0, 300)),
                 f"{dice.choice(WHOLES[:9])}#{dice.randint(0, 100)}", "st.n", "pINT^", "fb.o"]
            )  # fmt: skip
        one, two = self.whole(deep - 1), self.whole(deep - 1)
        kind = dice.choice(WHOLES)
        return dice.choice(
            [
                f"({one} + {two})", f"({one} - {two})", f"({one} * {two})", f"({one} / {two})",
                f"({one} MOD {two})", f"({one} AND {two})", f"({one} OR {two})",
                f"({one} XOR {two})", f"NOT TO_{kind}({one})", f"ABS(TO_INT({one}))",
                f"TO_{kind}({one})", f"MIN({one}, {two})", f"MAX({one}, {two})",
                f"LIMIT({one}, {two}, {self.whole(0)})",
                f"SEL({self.bool(deep - 1)}, {one}, {two})",
                f"MUX({self.whole(0)} AND 3, {one}, {two}, 7)",
                f"SHL(TO_{kind}({one}), {two} AND 63)",
                f"SHR(TO_{kind}({one}), {two} AND 63)", f"ROL(v{kind}, TO_INT({two}))",
                f"ROR(v{kind}, TO_INT({two}))", f"TO_{kind}({self.real(deep - 1)})",
                f"TRUNC({self.real(deep - 1)})", f"BOOL_TO_INT({self.bool(deep - 1)})",
                f"fnAdd({one}, {self.real(deep - 1)})", f"fb.Twice({one})", f"ifc.Twice({one})",
                f"LEN({self.text(deep - 1)})", f"STRING_TO_DINT({self.text(deep - 1)})",
                f"TO_LINT(v{dice.choice(TIMES)})", f"FIND({self.text(deep - 1)}, 'a')",
            ]
        )  # fmt: skip

    def real(self, deep: int = 3) -> str:
        """A real."""
        dice = self.dice
        if deep == 0 or dice.random() < 0.2:
            return dice.choice(
                ["vREAL", "vLREAL", f"{dice.uniform(-50, 50):.3f}", "st.r", "aREAL[i]"]
            )
        one, two = self.real(deep - 1), self.real(deep - 1)
        return dice.choice(
            [
                f"({one} + {two})", f"({one} - {two})", f"({one} * {two})", f"({one} / {two})",
                f"-({one})", f"ABS({one})", f"SQRT({one})", f"SIN({one})", f"EXP({one})",
                f"LN({one})", f"EXPT({one}, {two})", f"MIN({one}, {two})", f"MAX({one}, {two})",
                f"LIMIT({one}, {two}, 3.5)", f"TO_REAL({self.whole(deep - 1)})", f"TO_REAL({one})",
                f"TO_LREAL({self.whole(deep - 1)})", f"SEL({self.bool(deep - 1)}, {one}, {two})",
                f"ATAN({one})", f"TAN({one})", f"STRING_TO_LREAL({self.text(deep - 1)})",
            ]
        )  # fmt: skip

    def bool(self, deep: int = 3) -> str:
        """A truth."""
        dice = self.dice
        if deep == 0 or dice.random() < 0.2:
            return dice.choice(
                ["vBOOL", "vWORD.5", "vLINT.63", "vSINT.7", "TRUE", "st.b", "aBOOL[i]"]
            )
        one, two = self.bool(deep - 1), self.bool(deep - 1)
        sign = dice.choice(["=", "<>", "<", "<=", ">", ">="])
        return dice.choice(
            [
                f"({one} AND {two})", f"({one} OR {two})", f"({one} XOR {two})", f"NOT {one}",
                f"({one} AND_THEN {two})", f"({one} OR_ELSE {two})", f"({one} = {two})",
                f"({self.whole(deep - 1)} {sign} {self.whole(deep - 1)})",
                f"({self.real(deep - 1)} {sign} {self.real(deep - 1)})",
                f"({self.text(deep - 1)} {sign} {self.text(deep - 1)})", f"(vTIME {sign} T#3s)",
                f"TO_BOOL({self.whole(deep - 1)})", f"SEL({one}, {two}, vBOOL)",
            ]
        )  # fmt: skip

    def text(self, deep: int = 2) -> str:
        """A STRING."""
        dice = self.dice
        if deep <= 0 or dice.random() < 0.3:
            return dice.choice(["vSTRING", "vSTRING7", "'abcab'", "''", "st.s"])
        one, two = self.text(deep - 1), self.text(deep - 1)
        size, at = dice.randint(-1, 6), dice.randint(-1, 6)
        return dice.choice(
            [
                f"CONCAT({one}, {two})", f"LEFT({one}, {size})", f"RIGHT({one}, {size})",
                f"MID({one}, {size}, {at})", f"INSERT({one}, {two}, {at})",
                f"DELETE({one}, {size}, {at})", f"REPLACE({one}, {two}, {size}, {at})",
                f"DINT_TO_STRING(TO_DINT({self.whole(1)}))", f"fnText({one}, {self.whole(0)})",
                f"REAL_TO_STRING({self.real(1)})", f"BOOL_TO_STRING({self.bool(1)})",
                "WSTRING_TO_STRING(vWSTRING)", "TIME_TO_STRING(vTIME)",
            ]
        )  # fmt: skip

    def assignment(self) -> str:
        """A statement without others in it."""
        dice = self.dice
        kind = dice.choice(WHOLES)
        return dice.choice(
            [
                f"v{kind} := TO_{kind}({self.whole()});",
                f"a{kind}[i] := TO_{kind}({self.whole()});",
                f"vINT := vSINT := TO_SINT({self.whole()});", f"vREAL := TO_REAL({self.real()});",
                f"vLREAL := {self.real()};", f"aREAL[i] := TO_REAL({self.real()});",
                f"vBOOL := {self.bool()};", f"aBOOL[i] := {self.bool()};",
                f"vWORD.{dice.randint(0, 15)} := {self.bool()};", f"vBOOL S= {self.bool()};",
                f"vLINT.63 R= {self.bool()};", f"vSTRING := {self.text()};",
                f"vSTRING7 := {self.text()};", f"vWSTRING := STRING_TO_WSTRING({self.text()});",
                f"st.n := TO_INT({self.whole()});", f"st.s := {self.text()};", "su := st;",
                f"pINT := ADR(aINT[{dice.randint(0, 3)}]);", f"pINT^ := TO_INT({self.whole()});",
                f"pBYTE := ADR(st) + {dice.randint(0, 9)}; pBYTE^ := TO_BYTE({self.whole(1)});",
                f"fb(i := TO_INT({self.whole()}), x := {self.bool(1)}, io := vDINT, o => vINT);",
                f"fbs[i](i := TO_INT({self.whole(1)}), io := vDINT);", "vTIME := vTIME + T#7ms;",
                "vLTIME := TIME_TO_LTIME(vTIME) + LTIME#3ns;", "vDATE := DT_TO_DATE(vDT);",
                "vTOD := DT_TO_TOD(vDT);", f"vDT := vDT + T#{dice.randint(1, 90000)}s;",
                "ifc := fb;", "ifc := fbs[i];",
                f"grid[i, TO_INT(vUSINT) MOD 2] := TO_DINT({self.whole(1)});",
                f"i := TO_INT({self.whole()}) MOD {dice.choice([4, 4, 4, 5])};",
            ]
        )  # fmt: skip

    def statements(self, count: int) -> str:
        """Some statements."""
        return "\n".join(self.statement() for _ in range(count))

    def statement(self) -> str:
        """A statement, perhaps with others in it."""
        dice = self.dice
        if self.depth >= 3 or dice.random() < 0.6:
            return self.assignment()
        self.depth += 1
        few = dice.randint(1, 3)
        counter = f"k{self.loops % 4}"
        self.loops += 1
        label = f"m{self.loops}"
        ways = [
            lambda: (
                f"IF {self.bool()} THEN\n{self.statements(few)}\nELSIF {self.bool(1)} THEN\n"
                f"{self.statements(1)}\nELSE\n{self.statements(1)}\nEND_IF"
            ),
            lambda: (
                f"CASE TO_INT({self.whole()}) OF\n0, 5..9:\n{self.statements(1)}\n-9..300:\n"
                f"{self.statements(few)}\nELSE\n{self.statements(1)}\nEND_CASE"
            ),
            lambda: (
                f"FOR {counter} := {dice.randint(-3, 3)} TO TO_SINT({self.whole(0)}) AND 7 BY"
                f" {dice.choice([1, 2, -1])} DO\n{self.statements(few)}\n"
                f"IF {self.bool(1)} THEN {dice.choice(['EXIT', 'CONTINUE'])}; END_IF\n"
                f"{self.statements(1)}\nEND_FOR"
            ),
            lambda: (
                f"WHILE {self.bool(1)} DO\n{self.statements(few)}\n{counter} := {counter} + 1;"
                f"\nIF {counter} > 5 THEN EXIT; END_IF\nEND_WHILE"
            ),
            lambda: (
                f"REPEAT\n{self.statements(few)}\n{counter} := {counter} + 1;\nUNTIL"
                f" {counter} > 3 OR {self.bool(1)}\nEND_REPEAT"
            ),
            lambda: (
                f"__TRY\n{self.statements(few)}\n__CATCH(vException)\n{self.statements(1)}\n"
                f"__FINALLY\n{self.assignment()}\n__ENDTRY"
            ),
            lambda: (
                f"IF {self.bool(1)} THEN\nJMP {label};\nEND_IF\n{self.statements(few)}\n"
                f"{label}: {self.assignment()}"
            ),
        ]
        statement = dice.choice(ways if self.depth == 1 else ways[:-1])()
        self.depth -= 1
        return statement

    def program(self) -> str:
        """A whole project."""
        dice = self.dice
        names = [
            f"v{kind} : {kind} := {dice.randint(0, 120)};\na{kind} : ARRAY[0..3] OF {kind};"
            for kind in WHOLES
        ]
        names += [f"v{kind} : {kind} := {dice.uniform(-9, 9):.3f};" for kind in REALS]
        names += [f"v{kind} : {kind};" for kind in TIMES]
        return f"""
TYPE T_Item : STRUCT n : INT := 4; r : REAL; b : BOOL; s : STRING(9) := 'item'; END_STRUCT END_TYPE
INTERFACE I_Item METHOD Twice : LINT VAR_INPUT n : LINT; END_VAR END_METHOD END_INTERFACE
FUNCTION fnAdd : DINT
VAR_INPUT a : DINT; b : LREAL; END_VAR
VAR t : ARRAY[0..2] OF INT; END_VAR
t[1] := TO_INT(a); fnAdd := t[1] + TO_INT(b);
END_FUNCTION
FUNCTION fnText : STRING(20)
VAR_INPUT s : STRING(20); n : LINT; END_VAR
IF n > 50 THEN RETURN; END_IF
fnText := CONCAT(s, LINT_TO_STRING(n));
END_FUNCTION
FUNCTION_BLOCK FB_Item IMPLEMENTS I_Item
VAR_INPUT i : INT; x : BOOL; END_VAR
VAR_OUTPUT o : INT; END_VAR
VAR_IN_OUT io : DINT; END_VAR
VAR k : LREAL; item : T_Item; END_VAR
o := o + i; IF x THEN o := -o; END_IF
k := k + o; io := io + o; item.n := o;
METHOD Twice : LINT
VAR_INPUT n : LINT; END_VAR
Twice := n * 2 + item.n; o := o + 1;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
{chr(10).join(names)}
vBOOL : BOOL; aBOOL : ARRAY[0..3] OF BOOL; aREAL : ARRAY[0..3] OF REAL;
vSTRING : STRING := 'a1b2'; vSTRING7 : STRING(7); vWSTRING : WSTRING(5) := "wide"; st, su : T_Item;
pINT : POINTER TO INT := ADR(vINT); pBYTE : POINTER TO BYTE; i, k0, k1, k2, k3 : INT;
fb : FB_Item; fbs : ARRAY[0..3] OF FB_Item; ifc : I_Item := fb; grid : ARRAY[0..3, -1..1] OF DINT;
vException : UDINT; nCycle : INT;
END_VAR
nCycle := nCycle + 1;
{self.statements(12)}
END_PROGRAM
"""


@pytest.mark.parametrize("first", range(6))
def test_random_programs_leave_the_same_bytes(
    run: Run, form: CodeForm, first: int, many: Callable[[int], int]
) -> None:
    """The fixture compares with plain code after each cycle; a fault stops both alike."""
    if form is CodeForm.PLAIN:
        pytest.skip("machine code is compared with it")
    for seed in range(first, 6 * many(1), 6):
        run(Author(seed).program(), cycles=4, exceptions=seed % 2 == 0, budget=20_000)
