"""LinuxCNC's stand-alone interpreter as a witness: translate a program, run it, read its moves.

Where the dialects differ, the text is changed here: R5 becomes #105, formulas get brackets from
left to right, a radius B or U becomes R, G54..G57 become G55..G58 (there G54 is always on, here
nothing is), G58 becomes G52, ROT Z a rotation of the coordinate system, D a diameter. The witness
has no cutter compensation in YZ.
"""

import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path

from achse.gcode.canon import ArcMove, LineMove

__all__ = ["SYSTEMS", "Refused", "WitnessMove", "of_ours", "run", "translated"]

SYSTEMS = {"G53": (1, "G54"), "G54": (2, "G55"), "G55": (3, "G56"), "G56": (4, "G57"),
           "G57": (5, "G58")}  # fmt: skip
"""Ours, and the number and name of the coordinate system there."""


class Refused(Exception):
    """The witness does not run this program."""


@dataclass(frozen=True)
class WitnessMove:
    """A move of the axes: what both interpreters have to agree in."""

    kind: str
    """`rapid`, `feed`, or an arc by its plane and direction."""
    end: tuple[float, float, float]
    centre: tuple[float, float] | None = None
    grain: float = 1e-4
    """mm: four decimals of the unit that was printed."""

    def agrees(self, other: "WitnessMove") -> bool:
        """Are both the same to the coarser of the two grains?"""
        if self.kind != other.kind or (self.centre is None) != (other.centre is None):
            return False
        mine, theirs = (*self.end, *(self.centre or ())), (*other.end, *(other.centre or ()))
        grain = max(self.grain, other.grain)
        return all(abs(a - b) <= grain for a, b in zip(mine, theirs, strict=True))


_AXES = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
_NAMES = {"XY": "XY", "ZX": "XZ", "YZ": "YZ"}


def of_ours(move: LineMove | ArcMove) -> WitnessMove:
    """Our move in the same form."""
    if isinstance(move, LineMove):
        return WitnessMove("rapid" if move.rapid else "feed", move.end)
    plane = move.plane
    assert plane is not None
    first, second, _ = plane.axes
    direction = "clockwise" if move.clockwise else "counter-clockwise"
    return WitnessMove(
        f"{_NAMES[plane.name]} {direction}",
        move.end,
        (move.centre[first], move.centre[second]),
    )


_CALL = re.compile(r"([A-Z_0-9]+)\(([^()]*)\)\s*$")


def run(text: str, folder: Path) -> list[WitnessMove]:
    """The moves that rs274 gives for a program of its own dialect."""
    program, tools, variables = folder / "part.ngc", folder / "tool.tbl", folder / "rs274.var"
    program.write_text(text, encoding="ascii")
    tools.write_text(";none\n", encoding="ascii")
    variables.write_text("5220\t1\n", encoding="ascii")
    finished = subprocess.run(
        ["rs274", "-g", "-t", str(tools), "-v", str(variables), str(program)],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    if finished.returncode or "PROGRAM_END" not in finished.stdout:
        raise Refused(finished.stderr.replace("executing", "").strip())
    return list(_moves(finished.stdout))


def _moves(printed: str) -> Iterator[WitnessMove]:
    """Canonical calls are in the program's coordinates and units: carried over to the axes."""
    shift, extra, turn, factor, plane = (0.0,) * 3, (0.0,) * 3, 0.0, 1.0, "XY"

    def to_axes(point: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = ((a + b) * factor for a, b in zip(point, extra, strict=True))
        c, s = cos(radians(turn)), sin(radians(turn))
        x, y = c * x - s * y, s * x + c * y
        a, b, d = (each * factor for each in shift)
        return (x + a, y + b, z + d)

    for line in printed.splitlines():
        match = _CALL.search(line)
        if match is None:
            continue
        name, words = match[1], match[2].split(", ")
        if name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            x, y, z = map(float, words[:3])
            kind = "rapid" if name.endswith("TRAVERSE") else "feed"
            yield WitnessMove(kind, to_axes((x, y, z)), grain=1.01e-4 * factor)
        elif name == "ARC_FEED":
            values = [float(word) for word in words]
            first, second, third = _AXES[plane]
            end, centre = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
            end[first], end[second], end[third] = values[0], values[1], values[5]
            centre[first], centre[second] = values[2], values[3]
            at = to_axes((centre[0], centre[1], centre[2]))
            direction = "clockwise" if values[4] < 0 else "counter-clockwise"
            yield WitnessMove(
                f"{plane} {direction}",
                to_axes((end[0], end[1], end[2])),
                (at[first], at[second]),
                1.01e-4 * factor,
            )
        elif name == "SELECT_PLANE":
            plane = words[0].removeprefix("CANON_PLANE_")
        elif name == "USE_LENGTH_UNITS":
            inches = words[0].endswith("INCHES")
            if inches != (factor != 1.0):
                scale = 1.0 / 25.4 if inches else 25.4
                shift = (shift[0] * scale, shift[1] * scale, shift[2] * scale)
                extra = (extra[0] * scale, extra[1] * scale, extra[2] * scale)
            factor = 25.4 if inches else 1.0
        elif name == "SET_G5X_OFFSET":
            x, y, z = map(float, words[1:4])
            shift = (x, y, z)
        elif name == "SET_G92_OFFSET":
            x, y, z = map(float, words[:3])
            extra = (x, y, z)
        elif name == "SET_XY_ROTATION":
            turn = float(words[0])


_OPERATORS = re.compile(r"(?<=[\d\]])([-+*/])")
_UNITS = {"G70": "G20", "G71": "G21", "G700": "G20", "G710": "G21"}
_LOST = {"CPCON", "CPCOF", "CFC", "CFIN", "CFTCP", "FCONST", "FLIN", "G09", "G60", "G08", "CDOF"}
"""Words without a counterpart that change no geometry."""


def _bracketed(formula: str) -> str:
    """`R1+R2*3` as `[[#101+#102]*3]`."""
    formula = re.sub(r"R(\d+)", lambda match: f"#{int(match[1]) + 100}", formula)
    formula = re.sub(r"(SIN|COS|TAN|SQRT|ABS)\(([^()]*)\)", r"\1[\2]", formula)
    parts = _OPERATORS.split(formula)
    text = parts[0]
    for operator, term in zip(parts[1::2], parts[2::2], strict=True):
        text = f"[{text}{operator}{term}]"
    return text if text.startswith(("[", "#")) or not parts[1:] else f"[{text}]"


def translated(text: str, diameters: dict[int, float] | None = None) -> str:
    """The program in the dialect of the witness."""
    lines = ["G21 G90 G17 G40 G54"]
    system = "G53"
    for line in text.upper().splitlines():
        words, before = [], []
        tokens = line.split()
        for at, word in enumerate(tokens):
            if match := re.fullmatch(r"R(\d+)=(.+)", word):
                before.append(f"#{int(match[1]) + 100}={_bracketed(match[2])}")
            elif word in _UNITS:
                words.append(_UNITS[word])
            elif word in SYSTEMS:
                system = word
                words.append(SYSTEMS[word][1])
            elif word in ("G41", "G42"):
                words.append(f"{word}.1")
            elif match := re.fullmatch(r"D(\d+)", word):
                words.append(f"D{(diameters or {})[int(match[1])]}")
            elif word == "G58":
                words.append("G52")
            elif word == "ROT":
                words = [f"G10 L2 P{SYSTEMS[system][0]} R{tokens[at + 1][1:]}"]
                break
            elif word == "G04":
                words = [f"G4 P{tokens[at + 1][1:]}"]
                break
            elif match := re.fullmatch(r"([XYZIJKF])=(.+)", word):
                words.append(f"{match[1]}{_bracketed(match[2])}")
            elif match := re.fullmatch(r"([BU])=?(.+)", word):
                words.append(f"R{_bracketed(match[2])}")
            elif word in ("X", "Y", "Z"):
                raise Refused("a bare letter has no counterpart")
            elif word not in _LOST:
                words.append(word)
        lines += before
        if words:
            lines.append(" ".join(words))
    if not lines[-1].startswith(("M2", "M02", "M30")):
        lines.append("M2")
    return "\n".join(lines) + "\n"
