"""Random expressions and programs do in memory what the rules say, cycle by cycle."""

import math
from collections.abc import Callable
from random import Random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec import plain
from achse.plc.retention.retained_state import inherit_variables, retained_variables
from achse.plc.runtime import PlcState
from tests.plc.code.conftest import Ran
from tests.rules.oracle import INTEGERS, Cell, Env, Place, Stop, wrap
from tests.rules.random_programs import Scope
from tests.rules.random_projects import Project


def _same(value: Any, wanted: Any) -> bool:
    if isinstance(wanted, float):
        if wanted != wanted:
            return bool(value != value)
        return bool(value == wanted and math.copysign(1, value) == math.copysign(1, wanted))
    return bool(value == wanted)


def _compare(value_: Any, wanted: Any, where: str, text: str) -> None:
    if isinstance(wanted, Cell):
        value = plain(value_)
        assert _same(value, wanted.v), f"{where} is {value!r}, expected {wanted.v!r}\n{text}"
    elif isinstance(wanted, list):
        for number, (one, cell) in enumerate(zip(plain(value_), wanted, strict=True)):
            _compare(one, cell, f"{where} element {number}", text)
    else:
        block = wanted.get("__block__")
        temporaries = {name for name, _, _ in block.all_of("temporaries")} if block else set()
        for name, cell in wanted.items():
            if not name.startswith("__") and name not in temporaries:
                _compare(value_[name], cell, f"{where}.{name}", text)


class Bench:
    """A random project beside the PLC that runs its text."""

    def __init__(self, project: Project, rng: Random, exceptions: bool) -> None:
        self.project, self.rng, self.exceptions = project, rng, exceptions
        self.ran = Ran(project.text, exceptions=exceptions)

    @property
    def plcs(self) -> list[Ran]:
        """The PLC, and its twin of plain code."""
        return [self.ran] if self.ran.twin is None else [self.ran, self.ran.twin]

    def agree(self, work: Callable[[], None]) -> bool:
        """Whether `work` of the project ends as what the PLC did, with the same variables; FALSE
        once both stopped."""
        text, plc, expected = self.project.text, self.ran.plc, ""
        try:
            work()
        except Stop as stop:
            expected = str(stop)
        if expected:
            assert plc.state is PlcState.EXCEPTION, f"expected {expected}\n{text}"
            assert self.ran.stopped.name == expected, f"{plc.failure}\n{text}"
        else:
            assert plc.state is not PlcState.EXCEPTION, f"{plc.failure}\n{text}"
            main, bodies = plc.instance("MAIN"), plc.bodies
            assert bodies is not None
            for name in self.project.names:
                _compare(main[name], self.project.main[name], name, text)
            placed = {one.name: one for one in (*plc.statics, *bodies.statics)}
            for name, cell in self.project.statics.items():
                one = placed[name]
                value = one.variable.type.read(plc.memory[one.area].data, one.offset)
                _compare(value, cell, name, text)
        return not expected

    def cycle(self) -> bool:
        """A cycle, at any time after the last."""
        clock = self.project.clock
        clock[0] += self.rng.choice(GAPS_NS) + self.rng.choice([0, 0, self.rng.randint(0, 10**7)])
        for each in self.plcs:
            each.task.due_ns = clock[0]
        self.ran.cycle()
        return self.agree(self.project.cycle)

    def press(self) -> None:
        """A client writes a variable."""
        name = self.rng.choice(self.project.names)
        cell = self.project.main[name]
        if isinstance(cell, Cell) and isinstance(cell.v, bool):
            cell.v = not cell.v
            self.ran.plc.instance("MAIN")[name] = cell.v

    def restart(self) -> bool:
        """Anything that begins the variables again."""
        kind = self.rng.choice(["cold", "origin", "station"])
        if kind == "station":
            retained = [retained_variables(each.plc) for each in self.plcs]
            self.ran = Ran(self.project.text, exceptions=self.exceptions)
            for each, values in zip(self.plcs, retained, strict=True):
                if each.plc.state is not PlcState.EXCEPTION:
                    assert inherit_variables(each.plc, values) == []
        for each in self.plcs if kind != "station" else ():
            each.plc.reset(origin=kind == "origin")
            if each.plc.state is not PlcState.EXCEPTION:
                each.plc.run()
        return self.agree(
            lambda: self.project.reset(origin=kind == "origin", again=kind == "station")
        )


_MS = 1_000_000
GAPS_NS = [1, _MS // 4, _MS, 10 * _MS, 10 * _MS, 30 * _MS, 1000 * _MS, 49 * 86_400_000 * _MS]
"""How long after one cycle the next is due."""


def _agree(project: Project, rng: Random, cycles: int, exceptions: bool) -> None:
    bench = Bench(project, rng, exceptions)
    if not bench.agree(project.begin):
        return
    for _ in range(cycles):
        if not bench.cycle():
            return
        bench.press()
        if rng.random() < 0.3 and not bench.restart():
            return


@given(st.integers(0, (1 << 64) - 1), st.integers(1, 6), st.booleans())
@settings(max_examples=10)
def test_programs(seed: int, cycles: int, exceptions: bool) -> None:
    rng = Random(seed)
    _agree(Project(rng, exceptions), rng, cycles, exceptions)


@given(st.integers(0, (1 << 64) - 1), st.integers(1, 5))
@settings(max_examples=20)
def test_expressions(seed: int, depth: int) -> None:
    """Many expressions at once: each into a LINT, which all results go into."""
    rng = Random(seed)
    scope = Scope(rng, exceptions=True)
    env: Env = {}
    declared = []
    for type in INTEGERS:
        name = f"x{type}"
        env[name] = Cell(wrap(rng.getrandbits(64), type))
        declared.append(f"{name} : {type} := {env[name].v};")
        scope.add(Place(name, type, lambda env, name=name: env[name]))  # type: ignore[misc]
    for name, type in (("r", "REAL"), ("l", "LREAL")):
        env[name] = Cell(rng.randint(-80, 80) / 8)
        declared.append(f"{name} : {type} := {env[name].v};")
        scope.add(Place(name, type, lambda env, name=name: env[name]))  # type: ignore[misc]
    values = [scope.integer(depth) for _ in range(8)]
    lines = [f"y{n} := {value.text};" for n, value in enumerate(values)]
    declared += [f"y{n} : LINT;" for n in range(len(values))]
    text = f"PROGRAM MAIN VAR {' '.join(declared)} END_VAR\n" + "\n".join(lines) + "\nEND_PROGRAM"
    ran = Ran(text).cycle()
    for n, value in enumerate(values):
        stop = ""
        try:
            wanted = wrap(value.run(env), "LINT")
        except Stop as reason:
            stop = str(reason)
        if stop:
            assert (ran.stopped.name, ran.stopped.line) == (stop, n + 2), text
            return
        assert ran[f"y{n}"] == wanted, f"{value.text}\n{text}"
    assert ran.plc.state is PlcState.RUN, ran.plc.failure
