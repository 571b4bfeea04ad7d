"""Instruction lists as text: one network of lines.

`label: OPERATOR operand (* comment *)`. Parameters of CAL are in brackets, on as many lines as
there are.

Source: IEC 61131-3 (2013) §7.2; exports in public repositories.
"""

import re

from achse.st.graphical.networks import DrawnNetwork, Instruction, NetworkList, NetworkOperand

_COMMENT = re.compile(r"\(\*.*?\*\)|//[^\n]*", re.DOTALL)
_HEADS = re.compile(r"^_IL_BODY[^\n]*", re.MULTILINE)
_LINE = re.compile(r"[ \t]*(?:(\w+)[ \t]*:(?!=))?[ \t]*([&\w]+)?[ \t]*(.*?)[ \t;]*\Z", re.DOTALL)


def read_instruction_text(text: str) -> NetworkList:
    """Return an instruction list as networks, a new one at each label."""
    text = _HEADS.sub(_blank, _COMMENT.sub(_blank, text))
    networks: list[DrawnNetwork] = []
    label, lines, start = "", [], 0  # type: tuple[str, list[Instruction], int]
    for at, line in _lines(text):
        match = _LINE.match(line)
        assert match is not None
        name, operator, operand = match[1] or "", match[2] or "", match[3]
        if name:
            if lines or label:
                networks.append(_network(len(networks) + 1, label, lines, start))
            label, lines, start = name, [], at
        if operator or operand:
            opens = "(" if operand.startswith("(") and operator.upper()[:3] != "CAL" else ""
            closes = ")" if operand.count(")") > operand.count("(") else ""
            if not operator and operand.startswith(")"):
                operator, operand, closes = ")", "", ""
            operand = operand[len(opens) :].removesuffix(")" if closes else "")
            if opens and operand.endswith(")"):
                operand, closes = operand[:-1], ")"
            place = NetworkOperand(operand.strip(), 0, at, at)
            lines.append(Instruction("", operator + opens, place, closes, at))
    networks.append(_network(len(networks) + 1, label, lines, start))
    return NetworkList("Il", tuple(networks))


def _network(number: int, label: str, lines: list[Instruction], at: int) -> DrawnNetwork:
    return DrawnNetwork(number, "", label, False, (), tuple(lines), at)


def _blank(match: "re.Match[str]") -> str:
    return re.sub(r"[^\n]", " ", match[0])


def _lines(text: str) -> list[tuple[int, str]]:
    """Lines with their offsets; a call with open brackets is one."""
    lines: list[tuple[int, str]] = []
    start = 0
    for line in text.split("\n"):
        if line.strip():
            last = lines[-1][1] if lines else ""
            if last.strip()[:3].upper() == "CAL" and last.count("(") > last.count(")"):
                lines[-1] = (lines[-1][0], f"{last}\n{line}")
            else:
                lines.append((start + len(line) - len(line.lstrip()), line))
        start += len(line) + 1
    return lines
