"""Rows of rules: Structured Text in, what is in memory afterwards out.

`*.tsv` has one rule a line: key, declarations of MAIN, statements, what is expected. `*.st` has
longer ones: `//= key`, then the source; without a PROGRAM, declarations of MAIN up to `---`, then
statements. Expectations are `; ` apart, in `*.st` behind `//?`:

    n = -3                a variable of MAIN afterwards, a Python literal; `inf`, `nan` too
    GVL.n = 3             a variable of another list or program
    @2 n = 3              the same after the second cycle
    @2 n := 3             before the second cycle a client writes this
    n is 03 00            its bytes
    stopped DIVIDEBYZERO 4    the PLC is in EXCEPTION, with this line of the source
    refused words         the checker says this
    option name value     of the bodies: exceptions, budget
"""

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

FOLDER = Path(__file__).parents[1] / "data" / "st_rules"
_PLACE = r"(?:@(?P<cycle>\d+) )?(?P<name>[\w.\[\]]+)"
_FORMS = {
    "is": re.compile(_PLACE + r" is (?P<value>[0-9A-Fa-f ]+)$"),
    "write": re.compile(_PLACE + r" := (?P<value>.+)$"),
    "value": re.compile(_PLACE + r" = (?P<value>.+)$"),
    "stopped": re.compile(r"stopped (?P<name>[\w#]+)(?: (?P<value>\d+))?$"),
    "refused": re.compile(r"refused (?P<name>)(?P<value>.+)$"),
    "option": re.compile(r"option (?P<name>\w+) (?P<value>.+)$"),
}
_NUMBERS = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


class Expectation(NamedTuple):
    """One expectation: form, cycle (0: the last), what of, value."""

    form: str
    cycle: int
    name: str
    value: Any


@dataclass(frozen=True)
class Rule:
    """A row."""

    key: str
    text: str
    expectations: tuple[Expectation, ...]

    def of(self, form: str) -> list[Expectation]:
        """The expectations of one form."""
        return [one for one in self.expectations if one.form == form]

    @property
    def cycles(self) -> int:
        """How many cycles it takes to see."""
        return max([1, *(one.cycle for one in self.expectations)])


def _expectation(text: str, key: str) -> Expectation:
    for form, pattern in _FORMS.items():
        match = pattern.match(text)
        if match:
            parts = match.groupdict()
            value: Any = parts["value"]
            if form in ("value", "write", "option"):
                value = _NUMBERS.get(value) or ast.literal_eval(value)
            elif form == "is":
                value = bytes.fromhex(value)
            elif form == "stopped":
                value = int(value or 0)
            return Expectation(form, int(parts.get("cycle") or 0), parts["name"], value)
    raise ValueError(f"{key}: what is {text!r}?")


def _program(declarations: str, statements: str) -> str:
    return f"PROGRAM MAIN\nVAR\n{declarations}\nEND_VAR\n{statements}\nEND_PROGRAM\n"


def _short(path: Path) -> Iterator[Rule]:
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line or line.startswith("#"):
            continue
        key, declarations, statements, expected = line.split("\t")
        wanted = tuple(_expectation(one, key) for one in expected.split("; "))
        yield Rule(f"{path.stem}.{key}", _program(declarations, statements), wanted)


def _long(path: Path) -> Iterator[Rule]:
    for row in re.split(r"^//= ", path.read_text(encoding="utf-8"), flags=re.M)[1:]:
        key, _, rest = row.partition("\n")
        lines = rest.splitlines()
        wanted = [line[4:] for line in lines if line.startswith("//? ")]
        text = "\n".join(line for line in lines if not line.startswith("//? "))
        if "PROGRAM" not in text:
            declarations, _, statements = text.partition("---\n")
            text = _program(declarations.strip("\n"), statements.strip("\n"))
        expected = tuple(_expectation(one, key) for line in wanted for one in line.split("; "))
        yield Rule(f"{path.stem}.{key}", text, expected)


def rules() -> list[Rule]:
    """All rows."""
    rules_ = [rule for path in sorted(FOLDER.glob("*.tsv")) for rule in _short(path)]
    rules_ += [rule for path in sorted(FOLDER.glob("*.st")) for rule in _long(path)]
    return rules_
