"""Random statements: each is its text and a Python function that does what it says."""

from collections.abc import Callable
from random import Random

from tests.rules.oracle import (
    INTEGERS,
    WIDTHS,
    Action,
    Back,
    Env,
    Leave,
    Next,
    Place,
    Stop,
    Value,
    converted,
    wrap,
)
from tests.rules.random_expressions import Expressions


class Scope(Expressions):
    """What the statements of one routine see."""

    def __init__(self, rng: Random, exceptions: bool) -> None:
        super().__init__(rng, exceptions)
        self.calls: list[Callable[[Scope], Action]] = []
        """Statements that call blocks."""
        self.again: list[Callable[[], None]] = []
        """What a reset does with what has no cell."""
        self.counters: list[Place] = []
        self.loops = 0
        self.may_return = True

    def block(self, depth: int, most: int = 5) -> Action:
        actions = [self.statement(depth) for _ in range(self.rng.randint(1, most))]

        def run(env: Env) -> None:
            for action in actions:
                action.run(env)

        return Action("\n".join(action.text for action in actions), run)

    def statement(self, depth: int) -> Action:
        rng = self.rng
        simple = [self._assign] * 6 + [self._element_assign, self._bit, self._latch, self._chain]
        if self.calls:
            simple += [self._block_call] * 3
        nested = [self._if, self._if, self._case, self._for, self._while, self._repeat]
        if depth > 0 and rng.random() < 0.35:
            return rng.choice(nested)(depth - 1)
        if rng.random() < 0.05 and (self.loops or self.may_return):
            return self._leave()
        return rng.choice(simple)()

    def _assign(self) -> Action:
        types = [type for type in self.places if self.places[type]]
        place = self.any_place(self.rng.choice(types))
        assert place is not None
        value = self.argument(place.type, 3)
        return _assignment(place, value)

    def _chain(self) -> Action:
        a, b = self.any_place(*INTEGERS), self.any_place(*INTEGERS)
        assert a is not None
        assert b is not None
        value = self.integer(2)

        def run(env: Env) -> None:
            middle = wrap(value.run(env), b.type)
            b.cell(env).v = middle
            a.cell(env).v = wrap(middle, a.type)

        return Action(f"{a.text} := {b.text} := {value.text};", run)

    def _bit(self) -> Action:
        place = self.any_place(*INTEGERS)
        assert place is not None
        number, value = self.rng.randrange(WIDTHS[place.type][0]), self.boolean(2)

        def run(env: Env) -> None:
            state = value.run(env)
            cell = place.cell(env)
            cell.v = wrap(cell.v & ~(1 << number) | state << number, place.type)

        return Action(f"{place.text}.{number} := {value.text};", run)

    def _latch(self) -> Action:
        place = self.any_place("BOOL")
        if place is None:
            return self._assign()
        sets, value = self.rng.random() < 0.5, self.boolean(2)

        def run(env: Env) -> None:
            if value.run(env):
                place.cell(env).v = sets

        return Action(f"{place.text} {'S=' if sets else 'R='} {value.text};", run)

    def _element_assign(self) -> Action:
        if not self.arrays:
            return self._assign()
        name, type, first, last, cells = self.rng.choice(self.arrays)
        index = self.variable()
        if self.rng.random() < 0.1:
            value = self.variable() if type in WIDTHS else self.argument(type, 0)
            text = f"{name}[{index.text}]"
            if WIDTHS[index.type][0] < 64:

                def store(env: Env) -> None:
                    number = wrap(index.run(env), "DINT")
                    if not first <= number <= last:
                        raise Stop("ARRAYBOUNDS")
                    cells(env)[number - first].v = converted(value.run(env), value.type, type)

                return Action(f"{text} := {value.text};", store)
        value = self.argument(type, 2)
        text = f"{name}[LIMIT(DINT#{first}, TO_DINT({index.text}), DINT#{last})]"

        def run(env: Env) -> None:
            number = min(max(wrap(index.run(env), "DINT"), first), last) - first
            cells(env)[number].v = converted(value.run(env), value.type, type)

        return Action(f"{text} := {value.text};", run)

    def _block_call(self) -> Action:
        return self.rng.choice(self.calls)(self)

    def _leave(self) -> Action:
        words: list[tuple[str, type[Exception]]] = []
        if self.loops:
            words += [("EXIT", Leave), ("CONTINUE", Next)]
        if self.may_return:
            words.append(("RETURN", Back))
        word, signal = self.rng.choice(words)
        test = self.boolean(2)

        def run(env: Env) -> None:
            if test.run(env):
                raise signal

        return Action(f"IF {test.text} THEN {word}; END_IF", run)

    def _if(self, depth: int) -> Action:
        branches = [(self.boolean(3), self.block(depth, 3)) for _ in range(self.rng.randint(1, 3))]
        otherwise = self.block(depth, 3) if self.rng.random() < 0.5 else None
        text = "\n".join(
            f"{'IF' if not number else 'ELSIF'} {test.text} THEN\n{body.text}"
            for number, (test, body) in enumerate(branches)
        )
        text += f"\nELSE\n{otherwise.text}" if otherwise else ""

        def run(env: Env) -> None:
            for test, body in branches:
                if test.run(env):
                    body.run(env)
                    return
            if otherwise:
                otherwise.run(env)

        return Action(f"{text}\nEND_IF", run)

    def _case(self, depth: int) -> Action:
        selector = self._two(1)
        choices: list[tuple[int, int, Action]] = []
        low = 0 if not WIDTHS[selector.type][1] else -3
        for _ in range(self.rng.randint(1, 4)):
            choices.append((low, low + self.rng.randint(0, 3), self.block(depth, 2)))
            low = choices[-1][1] + self.rng.randint(1, 40)
        otherwise = self.block(depth, 2) if self.rng.random() < 0.5 else None
        text = "\n".join(
            f"{first if first == last else f'{first}..{last}'}:\n{body.text}"
            for first, last, body in choices
        )
        text += f"\nELSE\n{otherwise.text}" if otherwise else ""

        def run(env: Env) -> None:
            value = selector.run(env)
            for first, last, body in choices:
                if first <= value <= last:
                    body.run(env)
                    return
            if otherwise:
                otherwise.run(env)

        return Action(f"CASE {selector.text} OF\n{text}\nEND_CASE", run)

    def _looped(self, depth: int) -> Action:
        self.loops += 1
        body = self.block(depth, 3)
        self.loops -= 1
        return body

    def _for(self, depth: int) -> Action:
        if not self.counters:
            return self._if(depth)
        counter = self.counters.pop()
        start, end = self.rng.randint(0, 6), self.rng.randint(0, 6)
        step = self.rng.choice([1, 1, 2, 3, -1, -2]) if WIDTHS[counter.type][1] else 1
        body = self._looped(depth)
        self.counters.append(counter)
        by = "" if step == 1 and self.rng.random() < 0.7 else f" BY {step}"

        def run(env: Env) -> None:
            cell = counter.cell(env)
            cell.v = start
            while not (cell.v > end if step > 0 else cell.v < end):
                try:
                    body.run(env)
                except Leave:
                    return
                except Next:
                    pass
                cell.v = wrap(cell.v + step, counter.type)

        head = f"FOR {counter.text} := {start} TO {end}{by} DO"
        return Action(f"{head}\n{body.text}\nEND_FOR", run)

    def _while(self, depth: int) -> Action:
        return self._conditional(depth, before=True)

    def _repeat(self, depth: int) -> Action:
        return self._conditional(depth, before=False)

    def _conditional(self, depth: int, *, before: bool) -> Action:
        """WHILE or REPEAT with a counter, so that it ends."""
        if not self.counters:
            return self._if(depth)
        counter = self.counters.pop()
        test, most = self.boolean(2), self.rng.randint(1, 5)
        body = self._looped(depth)
        self.counters.append(counter)

        def step(env: Env) -> bool:
            cell = counter.cell(env)
            cell.v = wrap(cell.v + 1, counter.type)
            try:
                body.run(env)
            except Leave:
                return False
            except Next:
                pass
            return True

        def run(env: Env) -> None:
            cell = counter.cell(env)
            cell.v = 0
            if before:
                while cell.v < most and test.run(env) and step(env):
                    pass
            else:
                while step(env) and not (cell.v >= most or test.run(env)):
                    pass

        inner = f"{counter.text} := {counter.text} + 1;\n{body.text}"
        if before:
            head = f"WHILE {counter.text} < {most} AND_THEN {test.text} DO"
            text = f"{head}\n{inner}\nEND_WHILE"
        else:
            text = f"REPEAT\n{inner}\nUNTIL {counter.text} >= {most} OR_ELSE {test.text} END_REPEAT"
        return Action(f"{counter.text} := 0;\n{text}", run)


def _assignment(place: Place, value: Value) -> Action:
    def run(env: Env) -> None:
        place.cell(env).v = converted(value.run(env), value.type, place.type)

    return Action(f"{place.text} := {value.text};", run)
