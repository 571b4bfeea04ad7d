"""Networks drawn at random, against an interpreter of the drawing.

Drawn are ladders and function block diagrams: contacts, negated and with edges, series and parallel
branches, both forms of closed branches, wires, boxes with EN and ENO, timers' kin, coils that are
set, reset and negated, jumps forward, returns. The interpreter follows power as the manual of the
drawing says it and knows nothing of statements.
"""

from dataclasses import dataclass, field
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.st.graphical.drawings import (
    FALLING,
    JUMP,
    NEGATED,
    RESET,
    RETURN,
    RISING,
    SET,
    Drawn,
    assign,
    box,
    branches,
    contact,
    fb,
    network,
    networks,
    open_end,
    parallel,
    series,
    unit,
    wire,
)

INPUTS = ["a", "b", "c"]
MARKS = ["p", "q", "r"]
NUMBERS = ["m", "n"]
BLOCKS = ["t0", "t1"]
Node = tuple[Any, ...]
_key = st.integers(0, 1 << 30)
_modifier = st.sampled_from([0, 0, NEGATED, RISING, FALLING, NEGATED + RISING])
_bool = st.tuples(st.just("contact"), st.sampled_from(INPUTS + MARKS), _modifier, _key)


def _with_boxes(inner: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    several = st.lists(inner, min_size=2, max_size=3)
    return st.one_of(
        st.tuples(st.just("and"), several),
        st.tuples(st.just("or"), several),
        st.tuples(st.just("add"), inner, st.sampled_from(NUMBERS), st.integers(0, 3)),
        st.tuples(st.just("less"), inner, st.sampled_from(NUMBERS), st.integers(0, 3)),
        st.tuples(st.just("block"), st.sampled_from(BLOCKS), inner, st.booleans(), _key),
        st.tuples(st.just("stored"), inner, st.sampled_from(MARKS)),
    )


_tree = st.recursive(_bool, _with_boxes, max_leaves=6)
_in_branch = st.one_of(
    _bool,
    st.tuples(st.just("and"), st.lists(_bool, min_size=2, max_size=2)),
    st.tuples(st.just("add"), st.just(("open",)), st.sampled_from(NUMBERS), st.integers(0, 3)),
    st.tuples(st.just("add"), _bool, st.sampled_from(NUMBERS), st.integers(0, 3)),
    st.tuples(st.just("block"), st.sampled_from(BLOCKS), st.just(("open",)), st.just(False), _key),
)
_closed = st.tuples(
    st.just("parallel"), _bool, st.lists(_in_branch, min_size=2, max_size=3), st.booleans()
)
_target = st.tuples(
    st.sampled_from(MARKS), st.sampled_from([0, 0, NEGATED, SET, RESET, JUMP, RETURN])
)
_rung = st.tuples(st.lists(_target, min_size=1, max_size=3), st.one_of(_tree, _closed))
_network = st.tuples(st.booleans(), st.one_of(st.none(), _tree), st.lists(_rung, max_size=2))


@dataclass
class Interpreter:
    """Runs the drawing itself."""

    is_ladder: bool
    values: dict[str, int] = field(default_factory=dict)
    memories: dict[Any, bool] = field(default_factory=dict)
    wire: bool = False

    def cycle(self, drawing: list[Any]) -> None:
        at = 0
        while at < len(drawing):
            is_disabled, wired, rungs = drawing[at]
            at += 1
            if is_disabled:
                continue
            if wired is not None:
                self.wire = self.flow(wired, True, (at, "wire"))
            for number, (targets, value) in enumerate(rungs):
                power = self.flow(value, True, (at, number))
                if wired is not None and number:
                    power = self.flow(("wire",), True, (at, number)) and power
                left = self.store(targets, power)
                if left == "return":
                    return
                if left == "jump":
                    at = len(drawing) - 1
                    break
            else:
                continue

    def store(self, targets: list[Any], power: bool) -> str:
        for name, modifier in targets:
            if modifier == JUMP:
                if power:
                    return "jump"
            elif modifier == RETURN:
                if power:
                    return "return"
            elif modifier in (SET, RESET):
                if power:
                    self.values[name] = modifier == SET
            else:
                self.values[name] = power != (modifier == NEGATED)
        return ""

    def edge(self, key: Any, now: bool, rises: bool) -> bool:
        before = self.memories.get(key, False)
        self.memories[key] = now
        return (now and not before) if rises else (before and not now)

    def flow(self, node: Node, power: bool, key: Any) -> bool:
        match node:
            case ("open",):
                return power
            case ("wire",):
                return self.wire
            case ("contact", name, modifier, _):
                value = bool(self.values[name]) != bool(modifier & NEGATED)
                if modifier & (RISING | FALLING):
                    value = self.edge(key, value, bool(modifier & RISING))
                return power and value
            case ("and", inputs):
                if not self.is_ladder:
                    values = [self.flow(one, True, (key, n)) for n, one in enumerate(inputs)]
                    return power and all(values)
                for number, one in enumerate(inputs):
                    power = self.flow(one, power, (key, number))
                return power
            case ("or", inputs):
                into = power if self.is_ladder else True
                values = [self.flow(one, into, (key, n)) for n, one in enumerate(inputs)]
                return power and any(values)
            case ("add", enable, name, amount):
                if self.flow(enable, power, (key, "en")):
                    self.values[name] += amount
                    return True
                return False
            case ("less", enable, name, limit):
                return self.flow(enable, power, (key, "en")) and self.values[name] < limit
            case ("block", name, value, negated, _):
                now = self.flow(value, power, (key, "in"))
                return self.edge(name, now != negated, True)
            case ("stored", value, name):
                stored = self.flow(value, power, (key, "v"))
                self.values[name] = stored
                return stored
            case ("parallel", value, inner, sequential):
                power = self.flow(value, power, (key, "in"))
                boxes = [one[0] in ("add", "block") for one in inner]
                if sequential or not any(boxes) or all(boxes):
                    powers = [self.flow(one, power, (key, n)) for n, one in enumerate(inner)]
                    return any(powers)
                bridged = False
                for number, one in enumerate(inner):
                    if not boxes[number]:
                        bridged |= self.flow(one, power, (key, number))
                if bridged:
                    return True
                powers = [
                    self.flow(one, power, (key, n)) for n, one in enumerate(inner) if boxes[n]
                ]
                return any(powers)
        raise AssertionError(node)


def drawn(node: Node) -> str:
    match node:
        case ("open",):
            return open_end()
        case ("contact", name, modifier, _):
            return contact(name, modifier)
        case ("and", inputs):
            return series(*map(drawn, inputs))
        case ("or", inputs):
            return branches(*map(drawn, inputs))
        case ("add", enable, name, amount):
            slots = [("ENO", None), ("", name)]
            return box("ADD", contact(name), contact(str(amount)), en=drawn(enable), outputs=slots)
        case ("less", enable, name, limit):
            inputs = contact(name), contact(str(limit))
            return box("LT", *inputs, en=drawn(enable), eno=False, outputs=[("", None)])
        case ("block", name, value, negated, _):
            return fb("R_TRIG", name, [("CLK", drawn(value))], pins=[NEGATED if negated else 0])
        case ("stored", value, name):
            return assign(drawn(value), name)
        case ("parallel", value, inner, sequential):
            return parallel([drawn(one) for one in inner], drawn(value), sequential=sequential)
    raise AssertionError(node)


def body_of(drawing: list[Any], is_ladder: bool) -> str:
    texts = []
    for is_disabled, wired, rungs in drawing:
        items = [] if wired is None else [wire(1, drawn(wired))]
        for number, (targets, value) in enumerate(rungs):
            tree = drawn(value)
            if wired is not None and number:
                tree = series(wire(1), tree)
            labels = [("out" if mod == JUMP else name, mod) for name, mod in targets]
            items.append(assign(tree, *labels))
        texts.append(network(*items, disabled=is_disabled))
    texts.append(network(assign(contact("a"), "last"), label="Out"))
    return networks(*texts, view="Ld" if is_ladder else "Fbd")


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.booleans(),
    st.lists(_network, min_size=1, max_size=4),
    st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=3, max_size=6),
)
def test_random_networks_do_what_the_drawing_says(
    is_ladder: bool, drawing: list[Any], inputs: list[tuple[bool, bool, bool]]
) -> None:
    variables = f"{','.join(INPUTS + MARKS)}, last : BOOL; {','.join(NUMBERS)} : INT; "
    variables += f"{','.join(BLOCKS)} : R_TRIG;"
    head = f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR"
    plc = Drawn(unit(head, body_of(drawing, is_ladder)))
    model = Interpreter(is_ladder, dict.fromkeys([*INPUTS, *MARKS, *NUMBERS, "last"], 0))
    last = (False, None, [([("last", 0)], ("contact", "a", 0, 0))])
    for row in inputs:
        given_values = dict(zip(INPUTS, row, strict=True))
        model.values.update(given_values)
        model.cycle([*drawing, last])
        plc.cycle(**given_values)
        values = {name: int(plc[name]) for name in [*MARKS, *NUMBERS, "last"]}
        assert values == {name: int(model.values[name]) for name in values}
