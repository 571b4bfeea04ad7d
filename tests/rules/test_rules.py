"""Every rule of the language, in plain and machine code: a row each in tests/data/st_rules."""

import math
from collections import Counter
from typing import Any

import pytest

from achse.iec import plain
from achse.plc.runtime import PlcState
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source, SourceError
from achse.st.syntax.parser import parse
from tests.plc.code.conftest import Ran
from tests.rules.rows import Expectation, Rule, rules

RULES = rules()


def _parts(name: str) -> list[Any]:
    """`a.b[1]` as steps."""
    steps: list[Any] = []
    for piece in name.replace("]", "").split("."):
        word, *indices = piece.split("[")
        steps += [word, *map(int, indices)]
    return steps


def _start(ran: Ran, name: str) -> tuple[Any, list[Any]]:
    """The unit that a name begins in, and the steps from there."""
    steps = _parts(name)
    try:
        return ran.plc.instance(str(steps[0])), steps[1:]
    except KeyError:
        return ran.plc.instance("MAIN"), steps


def _value(ran: Ran, name: str) -> Any:
    value, steps = _start(ran, name)
    for step in steps:
        value = value[step]
    return plain(value)


def _write(ran: Ran, name: str, value: Any) -> None:
    target, steps = _start(ran, name)
    for step in steps[:-1]:
        target = target[step]
    target[steps[-1]] = value


def _bytes(ran: Ran, name: str) -> bytes:
    wanted = name.lower()
    if "." in name:
        value, steps = _start(ran, name)
        for step in steps[:-1]:
            value = value[step]
        member = type(value).__iec__.member(str(steps[-1]))
        start = value.__iec_offset__ + member.offset
        return bytes(value.__iec_buffer__[start : start + member.type.size])
    for placed in ran.plc.variables:
        if placed.name.lower() in (wanted, f"main.{wanted}"):
            assert placed.bit is None
            return ran.plc.memory[placed.area].read(placed.offset, placed.variable.type.size)
    raise KeyError(name)


def _same(value: Any, wanted: Any) -> bool:
    if isinstance(wanted, float) and math.isnan(wanted):
        return isinstance(value, float) and math.isnan(value)
    return bool(value == wanted)


def _check(ran: Ran, wanted: Expectation) -> None:
    value = _bytes(ran, wanted.name) if wanted.form == "is" else _value(ran, wanted.name)
    assert _same(value, wanted.value), f"{wanted.name} is {value!r}, expected {wanted.value!r}"


def _refused(rule: Rule) -> list[str]:
    try:
        return [str(one) for one in check(declare([parse(Source(rule.text, "t.st"))])).faults]
    except SourceError as failure:
        return [str(failure)]


@pytest.mark.parametrize("rule", RULES, ids=[rule.key for rule in RULES])
def test_rule(rule: Rule) -> None:
    """In machine code, with plain code beside it that has to leave the same memory and faults."""
    refusals = rule.of("refused")
    if refusals:
        faults = _refused(rule)
        for refusal in refusals:
            assert any(refusal.value in one for one in faults), faults
        return
    ran = Ran(rule.text, **{one.name: one.value for one in rule.of("option")})
    stops = rule.of("stopped")
    for cycle in range(1, rule.cycles + 1):
        for one in rule.of("write"):
            if one.cycle == cycle:
                _write(ran, one.name, one.value)
        ran.cycle()
        if not stops:
            assert ran.plc.state is PlcState.RUN, f"{ran.plc.fault}\n{ran.plc.failure}"
        for one in (*rule.of("value"), *rule.of("is")):
            if (one.cycle or rule.cycles) == cycle:
                _check(ran, one)
    for stop in stops:
        assert (ran.stopped.name, stop.value and ran.stopped.line) == (stop.name, stop.value)


def test_the_keys_are_there_once() -> None:
    twice = [key for key, count in Counter(rule.key for rule in RULES).items() if count > 1]
    assert not twice
