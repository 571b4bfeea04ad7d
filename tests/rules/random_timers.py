"""Timers of random programs: what is told is counted from call to call, not from a start."""

from random import Random

from tests.rules.oracle import INTEGERS, Action, Env, wrap
from tests.rules.random_programs import Scope

UNITS = {"": ("UDINT", "T#", "ms", 1_000_000), "L": ("ULINT", "LTIME#", "ns", 1)}
"""By the prefix of a timer: its number, how a duration is written, nanoseconds of its unit."""

DURATIONS = [0, 1, 4, 10, 25, 100, 3_600_000]
"""Milliseconds."""


class Timer:
    """One of TON, TOF and TP. Times are whole numbers of `unit_ns`, and as long as `number`."""

    def __init__(self, kind: str, number: str, unit_ns: int, clock: list[int]) -> None:
        self.kind, self.number, self.unit_ns, self.clock = kind, number, unit_ns, clock
        self.begin()

    def begin(self) -> None:
        """As declared."""
        self.q = self.was = self.runs = False
        self.et = self.last = 0

    def call(self, on: bool, pt: int) -> None:
        """One call: time goes on from the call before."""
        now = self.clock[0] // self.unit_ns
        passed = wrap(self.et + now - self.last, self.number)
        rises, falls = on and not self.was, self.was and not on
        if self.kind == "TON":
            if rises:
                passed = 0
            self.et = min(passed, pt) if on else 0
            self.q = on and passed >= pt
        elif self.kind == "TOF":
            if on:
                self.q, self.et = True, 0
            elif self.q:
                if falls:
                    passed = 0
                self.q, self.et = passed < pt, min(passed, pt)
        elif self.q:
            self.q, self.et = passed < pt, min(passed, pt)
        elif on and self.et == 0:
            self.q, self.et = pt > 0, 0
        if self.kind == "TP" and not self.q and not on:
            self.et = 0
        self.was, self.last = on, now


def timer(rng: Random, name: str, scope: Scope, clock: list[int]) -> str:
    """A timer, whose calls join the scope: its declaration."""
    prefix = rng.choice(["", "", "L"])
    number, sign, unit, unit_ns = UNITS[prefix]
    kind = rng.choice(["TON", "TOF", "TP"])
    own = Timer(kind, number, unit_ns, clock)

    def called(of: Scope) -> Action:
        test, place, other = of.boolean(2), of.any_place("BOOL"), of.any_place(*INTEGERS)
        assert place is not None
        assert other is not None
        pt = of.rng.choice(DURATIONS) * 1_000_000 // unit_ns

        def run(env: Env) -> None:
            own.call(bool(test.run(env)), pt)
            place.cell(env).v = own.q
            other.cell(env).v = wrap(own.et, other.type)

        text = (
            f"{name}(IN := {test.text}, PT := {sign}{pt}{unit}, Q => {place.text});\n"
            f"{other.text} := TO_{other.type}({name}.ET);"
        )
        return Action(text, run)

    scope.again.append(own.begin)
    scope.calls += [called, called]
    return f"    {name} : {prefix}{kind};"
