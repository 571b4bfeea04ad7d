"""Programs drawn at random: written as text, each statement on a line of its own, and walked here
by rules of their own, which count what begins, what is taken, and how conditions come out."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

from achse.plc.lowering.decisions import MOST_CONDITIONS

__all__ = ["DrawnProgram"]

_NAMES = ("a", "b", "c", "d")


class _FailedError(Exception):
    """Division by 0."""


class _LeftError(Exception):
    """EXIT, CONTINUE or RETURN."""


@dataclass
class _Condition:
    """`left < right + number`, or `10 / left < number`, which fails at 0."""

    left: str
    right: str
    number: int
    divides: bool

    @property
    def text(self) -> str:
        if self.divides:
            return f"10 / {self.left} < {self.number}"
        return f"{self.left} < {self.right} + {self.number}"

    def holds(self, values: dict[str, int]) -> bool:
        left = values[self.left]
        if self.divides:
            return _divided(10, left) < self.number
        return left < values[self.right] + self.number


def _joined(operator: str, values: list[bool]) -> bool:
    if operator == "XOR":
        return values.count(True) % 2 == 1
    return all(values) if operator == "AND" else any(values)


@dataclass
class _Decision:
    """Conditions under an operator, NOT before some; `vectors` counts how all of them came out."""

    operator: str
    parts: "list[_Condition | _Decision]"
    negated: list[bool]
    vectors: Counter[tuple[bool | None, ...]] = field(default_factory=Counter)

    @property
    def text(self) -> str:
        texts = [
            f"{'NOT ' * no}({one.text})" for one, no in zip(self.parts, self.negated, strict=True)
        ]
        return f" {self.operator} ".join(texts)

    @property
    def size(self) -> int:
        return sum(one.size if isinstance(one, _Decision) else 1 for one in self.parts)

    def holds(self, values: dict[str, int]) -> bool:
        outcome, seen = self._walked(values)
        self.vectors[tuple(seen)] += 1
        return outcome

    def _walked(self, values: dict[str, int]) -> tuple[bool, list[bool | None]]:
        outcomes: list[bool] = []
        seen: list[bool | None] = []
        deciding = {"AND_THEN": False, "OR_ELSE": True}.get(self.operator)
        for one, no in zip(self.parts, self.negated, strict=True):
            if deciding is not None and deciding in outcomes:
                seen += [None] * (one.size if isinstance(one, _Decision) else 1)
                continue
            if isinstance(one, _Decision):
                value, inside = one._walked(values)
            else:
                value = one.holds(values)
                inside = [value]
            seen += inside
            outcomes.append(value is not no)
        if deciding is not None:
            return deciding in outcomes if deciding else deciding not in outcomes, seen
        return _joined(self.operator, outcomes), seen


def _divided(left: int, right: int) -> int:
    if right == 0:
        raise _FailedError
    return int(left / right)


@dataclass
class _Step:
    """One statement: `kind` says what the other fields mean."""

    kind: str
    name: str = "a"
    number: int = 0
    conditions: "list[_Condition | _Decision]" = field(default_factory=list)
    labels: list[int] = field(default_factory=list)
    bodies: list[list["_Step"]] = field(default_factory=list)
    otherwise: list["_Step"] | None = None
    lines: list[int] = field(default_factory=list)


class DrawnProgram:
    """`text` is the program; `hits` and `taken` have what a walk through it counts, by line."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._lines = [
            "FUNCTION F_Share : INT", "VAR_INPUT n : INT; END_VAR", "F_Share := 1;",
            "F_Share := 6 / n;", "F_Share := F_Share + 1;", "END_FUNCTION",
        ]  # fmt: skip
        self.values = {name: random.randint(-2, 3) for name in _NAMES}
        self._steps = self._drawn(3, 0)
        starts = [f"{name} : INT := {value};" for name, value in self.values.items()]
        loops = [f"{letter}{number} : INT;" for letter in "iw" for number in range(4)]
        self._lines += ["PROGRAM MAIN", f"VAR {' '.join([*starts, *loops])} END_VAR"]
        self.hits: Counter[int] = Counter(dict.fromkeys((3, 4, 5), 0))
        self.taken: Counter[tuple[int, str]] = Counter()
        self.vectors: dict[int, Counter[tuple[bool | None, ...]]] = {}
        """How the conditions of decisions came out, by line; None of those that were left out."""
        self._write(self._steps, 0)
        self._lines.append("END_PROGRAM")
        self.text = "\n".join(self._lines) + "\n"

    # drawing ---------------------------------------------------------------------------------

    def _drawn(self, depth: int, loops: int) -> list[_Step]:
        kinds = ["add", "add", "add", "add", "divide", "call"]
        kinds += ["if", "if", "case", "for", "while", "repeat", "try"] if depth else []
        kinds += ["EXIT", "CONTINUE"] if loops else []
        kinds += ["RETURN"] if self._random.random() < 0.1 else []
        return [
            self._step(self._random.choice(kinds), depth - 1, loops)
            for _ in range(self._random.randint(0, 4))
        ]

    def _decision(self, depth: int) -> _Condition | _Decision:
        random = self._random
        if depth == 0 or random.random() < 0.4:
            return self._condition()
        operator = random.choice(("AND", "OR", "XOR", "AND_THEN", "OR_ELSE"))
        parts = [self._decision(depth - 1) for _ in range(2 if operator != "AND" else 3)]
        if "_" in operator:
            parts = parts[:2]
        return _Decision(operator, parts, [random.random() < 0.2 for _ in parts])

    def _condition(self) -> _Condition:
        random = self._random
        left, right = random.choice(_NAMES), random.choice(_NAMES)
        return _Condition(left, right, random.randint(-2, 3), random.random() < 0.1)

    def _step(self, kind: str, depth: int, loops: int) -> _Step:
        random = self._random
        step = _Step(kind, random.choice(_NAMES), random.randint(-2, 3))
        if kind in ("if", "case"):
            count = random.randint(1, 3)
            step.conditions = [self._decision(2) for _ in range(count)]
            step.labels = random.sample(range(-3, 5), count)
            step.bodies = [self._drawn(depth, loops) for _ in range(count)]
            step.otherwise = self._drawn(depth, loops) if random.random() < 0.5 else None
        elif kind in ("for", "while", "repeat"):
            step.number, step.conditions = random.randint(0, 3), [self._condition()]
            step.bodies = [self._drawn(depth, loops + 1)]
        elif kind == "try":
            final = [_Step("add", random.choice(_NAMES), 1) for _ in range(random.randint(0, 2))]
            step.bodies = [self._drawn(depth, loops), self._drawn(depth, loops), final]
        return step

    # text ------------------------------------------------------------------------------------

    def _line(self, text: str, *branches: str, counts: bool = True) -> int:
        self._lines.append(text)
        number = len(self._lines)
        if counts:
            self.hits[number] = 0
        for name in branches:
            self.taken[number, name] = 0
        return number

    def _write(self, steps: Sequence[_Step], loops: int) -> None:
        for step in steps:
            self._write_step(step, loops)

    def _write_step(self, step: _Step, loops: int) -> None:
        name, number = step.name, step.number
        match step.kind:
            case "add":
                step.lines = [self._line(f"{name} := {name} + {number};")]
            case "divide":
                step.lines = [self._line(f"{name} := {number} / {name};")]
            case "call":
                step.lines = [self._line(f"{name} := F_Share({name});")]
            case "EXIT" | "CONTINUE" | "RETURN":
                step.lines = [self._line(f"{step.kind};")]
            case "if":
                word = "IF"
                for condition, body in zip(step.conditions, step.bodies, strict=True):
                    text = f"{word} {condition.text} THEN"
                    step.lines.append(self._line(text, "TRUE", "FALSE", counts=word == "IF"))
                    if isinstance(condition, _Decision) and condition.size <= MOST_CONDITIONS:
                        self.vectors[step.lines[-1]] = condition.vectors
                    self._write(body, loops)
                    word = "ELSIF"
                self._write_else(step, loops, "END_IF")
            case "case":
                labels = [str(label) for label in step.labels]
                step.lines = [self._line(f"CASE {name} OF", *labels, "ELSE")]
                for label, body in zip(labels, step.bodies, strict=True):
                    self._line(f"{label}:", counts=False)
                    self._write(body, loops)
                self._write_else(step, loops, "END_CASE")
            case "for":
                head = f"FOR i{loops} := 1 TO {number} DO"
                step.lines = [self._line(head, "PASS", "END")]
                self._write(step.bodies[0], loops + 1)
                self._line("END_FOR", counts=False)
            case "while":
                first = self._line(f"w{loops} := 0;")
                head = f"WHILE w{loops} < {number} AND {step.conditions[0].text} DO"
                step.lines = [first, self._line(head, "PASS", "END")]
                self.vectors[step.lines[-1]] = Counter()
                step.lines.append(self._line(f"w{loops} := w{loops} + 1;"))
                self._write(step.bodies[0], loops + 1)
                self._line("END_WHILE", counts=False)
            case "repeat":
                step.lines = [self._line(f"w{loops} := 0;"), self._line("REPEAT", "AGAIN", "END")]
                self.vectors[step.lines[-1]] = Counter()
                step.lines.append(self._line(f"w{loops} := w{loops} + 1;"))
                self._write(step.bodies[0], loops + 1)
                text = f"UNTIL w{loops} >= {number} OR {step.conditions[0].text} END_REPEAT"
                self._line(text, counts=False)
            case "try":
                step.lines = [self._line("__TRY")]
                for body, end in zip(
                    step.bodies, ("__CATCH", "__FINALLY", "__ENDTRY"), strict=True
                ):
                    self._write(body, loops)
                    self._line(end, counts=False)

    def _write_else(self, step: _Step, loops: int, end: str) -> None:
        if step.otherwise is not None:
            self._line("ELSE", counts=False)
            self._write(step.otherwise, loops)
        self._line(end, counts=False)

    # walk ------------------------------------------------------------------------------------

    def walk(self) -> bool:
        """One cycle; False if it stops with an exception."""
        try:
            self._walk(self._steps)
        except _LeftError:
            return True
        except _FailedError:
            return False
        return True

    def _walk(self, steps: Sequence[_Step]) -> None:
        for step in steps:
            self._walk_step(step)

    def _walk_step(self, step: _Step) -> None:
        self.hits[step.lines[0]] += 1
        values, name = self.values, step.name
        match step.kind:
            case "add":
                values[name] += step.number
            case "divide":
                values[name] = _divided(step.number, values[name])
            case "call":
                self.hits[3] += 1
                self.hits[4] += 1
                share = _divided(6, values[name])
                self.hits[5] += 1
                values[name] = share + 1
            case "EXIT" | "CONTINUE" | "RETURN":
                raise _LeftError(step.kind)
            case "if":
                self._walk_if(step)
            case "case":
                where = step.labels.index(values[name]) if values[name] in step.labels else -1
                taken = "ELSE" if where < 0 else str(values[name])
                self.taken[step.lines[0], taken] += 1
                self._walk(step.bodies[where] if where >= 0 else step.otherwise or [])
            case "try":
                try:
                    try:
                        self._walk(step.bodies[0])
                    except _FailedError:
                        self._walk(step.bodies[1])
                finally:
                    self._walk(step.bodies[2])
            case _:
                self._walk_loop(step)

    def _walk_if(self, step: _Step) -> None:
        for line, condition, body in zip(step.lines, step.conditions, step.bodies, strict=True):
            holds = condition.holds(self.values)
            self.taken[line, "TRUE" if holds else "FALSE"] += 1
            if holds:
                self._walk(body)
                return
        self._walk(step.otherwise or [])

    def _walk_loop(self, step: _Step) -> None:
        passes, line = 0, step.lines[-2] if step.kind != "for" else step.lines[0]
        if step.kind != "for":
            self.hits[line] += 1
        while True:
            if step.kind != "repeat":
                goes_on = passes < step.number
                if step.kind == "while":
                    other = step.conditions[0].holds(self.values)
                    self.vectors[line][goes_on, other] += 1
                    goes_on &= other
                self.taken[line, "PASS" if goes_on else "END"] += 1
                if not goes_on:
                    return
            passes += 1
            if step.kind != "for":
                self.hits[step.lines[-1]] += 1
            try:
                self._walk(step.bodies[0])
            except _LeftError as left:
                if left.args[0] == "EXIT":
                    return
                if left.args[0] == "RETURN":
                    raise
            if step.kind == "repeat":
                ends = passes >= step.number
                other = step.conditions[0].holds(self.values)
                self.vectors[line][ends, other] += 1
                ends |= other
                self.taken[line, "END" if ends else "AGAIN"] += 1
                if ends:
                    return
