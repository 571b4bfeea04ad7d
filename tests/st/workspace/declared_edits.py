"""A project in which declarations rest on each other in all ways, and drawn edits of its words.

An edit puts a word in the place of another, takes lines away, doubles or swaps them, mends a
file, or adds, removes and renames files, so that sources are often wrong for some edits.
"""

import random
import re
from pathlib import Path

from tests.st.workspace.sample import FILES

__all__ = ["EditedProject"]

_MORE = {
    "Types.st": """TYPE T_Name : STRING(cLength); END_TYPE
TYPE T_Count : DINT := 4; END_TYPE
{attribute 'qualified_only'}
TYPE E_Mode : (Auto := 1, Manual, Service := Manual + 3) UINT := Manual; END_TYPE
TYPE ST_Axis :
STRUCT
    sName : T_Name;
    eMode : E_Mode;
    nState : (Still, Turning);
    stData : ST_Data;
    pNext : POINTER TO ST_Axis;
END_STRUCT
END_TYPE
TYPE ST_Drive EXTENDS ST_Axis :
STRUCT
    aLimits : ARRAY [0..cLength - 1, 1..2] OF LREAL;
END_STRUCT
END_TYPE
TYPE U_Word : UNION nWord : WORD; aBytes : ARRAY [0..1] OF BYTE; END_UNION END_TYPE
""",
    "Lists.st": """{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT
    cLength : INT := 3 + cMost;
    cFactor : LREAL := 2.5;
END_VAR
VAR_GLOBAL
    stAxis : ST_Axis := (sName := 'x', eMode := E_Mode.Auto);
    afbTimers : ARRAY [1..cLength] OF TON;
    fbGeneric : FB_Ring<4>;
    rtAxis : REFERENCE TO ST_Drive;
END_VAR
""",
    "Blocks.st": """FUNCTION_BLOCK FB_Ring
VAR_GENERIC CONSTANT nMost : DINT; END_VAR
VAR aItems : ARRAY [0..nMost] OF T_Count; nNext : DINT; END_VAR
METHOD PUBLIC Push : BOOL
VAR_INPUT nValue : T_Count; END_VAR
    aItems[nNext] := nValue;
    Push := nNext < nMost;
END_METHOD
END_FUNCTION_BLOCK

INTERFACE I_Solid EXTENDS I_Shape
METHOD Volume : LREAL
VAR_INPUT fHeight : LREAL; END_VAR
END_METHOD
PROPERTY Count : T_Count
GET
END_GET
END_PROPERTY
END_INTERFACE

FUNCTION_BLOCK FB_Base IMPLEMENTS I_Solid
VAR_INPUT nIn : INT; END_VAR
VAR nOwn : T_Count; pAxis : POINTER TO ST_Axis := ADR(stAxis); END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; nStart : T_Count; END_VAR
    nOwn := nStart;
END_METHOD
METHOD Area : REAL
    Area := LREAL_TO_REAL(Volume(1.0));
END_METHOD
METHOD Volume : LREAL
VAR_INPUT fHeight : LREAL; END_VAR
VAR_INST nCalls : INT; END_VAR
    nCalls := nCalls + 1;
    Volume := fHeight * cFactor;
END_METHOD
PROPERTY Count : T_Count
GET
    Count := nOwn;
END_GET
END_PROPERTY
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Middle EXTENDS FB_Base
VAR_OUTPUT nOut : INT; END_VAR
METHOD Volume : LREAL
VAR_INPUT fHeight : LREAL; END_VAR
    Volume := SUPER^.Volume(fHeight) + nOut;
END_METHOD
nOut := nIn;
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Last EXTENDS FB_Middle
VAR stOwn : ST_Drive; eLocal : (One, Two); END_VAR
stOwn.aLimits[1, 2] := stOwn.stData.rScale;
stOwn.eMode := E_Mode.Manual;
nOwn := Count + nOut;
eLocal := Two;
END_FUNCTION_BLOCK

FUNCTION F_Scale : ST_Data
VAR_INPUT stIn : ST_Data; fBy : LREAL; END_VAR
VAR_IN_OUT aAny : ARRAY [*] OF LREAL; END_VAR
F_Scale.rScale := stIn.rScale * LREAL_TO_REAL(fBy + aAny[1]);
END_FUNCTION
""",
    "Second.st": """PROGRAM SECOND
VAR
    fbLast : FB_Last(nStart := 7);
    iSolid : I_Solid;
    stResult : ST_Data;
    aValues : ARRAY [1..3] OF LREAL;
    nShort : INT;
    uWord : U_Word;
END_VAR
fbLast(nIn := nShort, nOut => nShort);
iSolid := fbLast;
aValues[2] := iSolid.Volume(fHeight := 2.0);
nShort := DINT_TO_INT(iSolid.Count);
stResult := F_Scale(stResult, 2.0, aAny := aValues);
Lists.fbGeneric.Push(nValue := nShort);
uWord.aBytes[0] := INT_TO_BYTE(nShort);
Lists.stAxis.pNext^.sName := 'next';
Lists.afbTimers[2](IN := fbLast.Area() > cFactor);
THIS^.nShort := 5;
SECOND.nShort := eNothing;
END_PROGRAM
""",
}
_ALL = {**FILES, **_MORE}
_WORD = re.compile(r"[A-Za-z_]\w*")
_KEYWORDS = frozenset(
    word.upper() for text in _MORE.values() for word in _WORD.findall(text) if word.isupper()
)
_POOL = sorted(
    {
        word
        for text in _ALL.values()
        for part in (re.findall(r"CDATA\[(.*?)\]\]>", text, re.DOTALL) or [text])
        for word in _WORD.findall(part)
        if word.upper() not in _KEYWORDS or word in ("INT", "DINT", "LREAL", "BOOL")
    }
)
_SPARE = "TYPE T_Spare : INT; END_TYPE\nFUNCTION F_Spare : T_Count\nEND_FUNCTION\n"
_OTHERS = ("Blocks.st", "Second.st", "Types.st")


class EditedProject:
    """Texts of a project in a folder, with edits that a generator draws."""

    def __init__(self, folder: Path, generator: random.Random) -> None:
        self.folder = folder
        self.texts = {folder / name: text for name, text in _ALL.items()}
        self._firsts = dict(self.texts)
        self._generator = generator
        for file, text in self.texts.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, "utf-8", newline="")

    def edit(self) -> Path:
        """Change the text of a file; return the file."""
        draw = self._generator
        changed = [file for file, text in self.texts.items() if text != self._firsts.get(file)]
        if len(changed) > 2 or (changed and draw.random() < 0.3):  # faults do not pile up
            file = draw.choice(changed)
            self.texts[file] = self._firsts.get(file, _SPARE)
            return file
        file = draw.choice([one for one in self.texts if one.suffix != ".TcTTO"])
        self.texts[file] = self.damaged(self.texts[file], draw)
        return file

    @staticmethod
    def damaged(text: str, draw: random.Random) -> str:
        """Return a text with one word, line or pair of lines other than before."""
        begin, end = 0, len(text)
        if parts := list(re.finditer(r"CDATA\[(.*?)\]\]>", text, re.DOTALL)):
            begin, end = draw.choice(parts).span(1)
        code = text[begin:end]
        lines = code.split("\n")
        at = draw.randrange(len(lines))
        words = list(_WORD.finditer(code))
        kind = draw.random()
        if kind < 0.6 and words:
            word = draw.choice(words)
            code = code[: word.start()] + draw.choice(_POOL) + code[word.end() :]
        elif kind < 0.7 and words:  # a new name, or half of one
            word = draw.choice(words)
            new = word[0] + "X" if draw.random() < 0.5 else word[0][:-1]
            code = code[: word.start()] + new + code[word.end() :]
        elif kind < 0.8:
            code = "\n".join([*lines[:at], *lines[at + 1 :]])
        elif kind < 0.9:
            code = "\n".join([*lines[: at + 1], *lines[at:]])
        else:
            other = draw.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
            code = "\n".join(lines)
        return text[:begin] + code + text[end:]

    def move_a_file(self) -> list[Path]:
        """Add, remove or rename a file on disk; return the files that are other than before."""
        draw = self._generator
        spare = self.folder / "Spare.st"
        moved = [one for one in self.texts if one.name.startswith("Moved")]
        if moved:
            file = moved[0]
            new = self.folder / file.name.removeprefix("Moved")
        elif draw.random() < 0.5:
            if spare in self.texts:
                del self.texts[spare]
                spare.unlink()
            else:
                self.texts[spare] = _SPARE
                spare.write_text(_SPARE)
            return [spare]
        else:
            file = self.folder / draw.choice(_OTHERS)
            new = file.with_name(f"Moved{file.name}")
        self.texts[new] = self.texts.pop(file)
        self._firsts[new] = self._firsts.pop(file)
        file.unlink()
        new.write_text(self.texts[new])
        return [file, new]
