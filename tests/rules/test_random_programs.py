"""Random expressions and programs do in memory what the rules say, cycle by cycle."""

import math
from random import Random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec import plain
from achse.plc.runtime import PlcState
from tests.plc.code.conftest import Ran
from tests.rules.oracle import INTEGERS, Cell, Env, Place, Stop, wrap
from tests.rules.random_programs import Scope
from tests.rules.random_projects import Project


def _same(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, float):
        if wanted != wanted:
            return bool(found != found)
        return bool(found == wanted and math.copysign(1, found) == math.copysign(1, wanted))
    return bool(found == wanted)


def _compare(found: Any, wanted: Any, where: str, text: str) -> None:
    if isinstance(wanted, Cell):
        value = plain(found)
        assert _same(value, wanted.v), f"{where} is {value!r}, expected {wanted.v!r}\n{text}"
    elif isinstance(wanted, list):
        for number, (one, cell) in enumerate(zip(plain(found), wanted, strict=True)):
            _compare(one, cell, f"{where} element {number}", text)
    else:
        block = wanted.get("__block__")
        temporaries = {name for name, _, _ in block.all_of("temporaries")} if block else set()
        for name, cell in wanted.items():
            if name != "__block__" and name not in temporaries:
                _compare(found[name], cell, f"{where}.{name}", text)


def _agree(project: Project, rng: Random, cycles: int, exceptions: bool) -> None:
    ran = Ran(project.text, exceptions=exceptions)
    for cycle in range(cycles):
        if cycle:
            name = rng.choice(project.names)
            cell = project.main[name]
            if isinstance(cell, Cell) and isinstance(cell.v, bool):
                cell.v = not cell.v
                ran.plc.instance("MAIN")[name] = cell.v
        expected = ""
        try:
            project.cycle()
        except Stop as stop:
            expected = str(stop)
        ran.cycle()
        main = ran.plc.instance("MAIN")
        if expected:
            assert ran.plc.state is PlcState.EXCEPTION, f"expected {expected}\n{project.text}"
            assert ran.stopped.name == expected, f"{ran.plc.failure}\n{project.text}"
        else:
            assert ran.plc.state is PlcState.RUN, f"{ran.plc.failure}\n{project.text}"
        for name in project.names:
            _compare(main[name], project.main[name], name, project.text)
        if expected:
            return


@given(st.integers(0, (1 << 64) - 1), st.integers(1, 4), st.booleans())
@settings(max_examples=17)
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
