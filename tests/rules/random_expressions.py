"""Random expressions: each is its text, its type, and a Python function that works it out."""

from collections.abc import Callable
from random import Random
from typing import Any

from tests.rules.oracle import (
    BITS,
    INTEGERS,
    WIDTHS,
    Cell,
    Env,
    Place,
    Routine,
    Value,
    converted,
    divided,
    literal,
    met,
    narrow,
    ordered,
    promoted,
    quotient,
    real_result,
    remainder,
    to_integer,
    wrap,
)


class Expressions:
    """What the statements of one routine see."""

    def __init__(self, rng: Random, exceptions: bool) -> None:
        self.rng = rng
        self.exceptions = exceptions
        self.places: dict[str, list[Place]] = {}
        self.arrays: list[tuple[str, str, int, int, Callable[[Env], list[Cell]]]] = []
        """Name, element type, first and last index, elements."""
        self.functions: list[Routine] = []

    def add(self, place: Place) -> None:
        self.places.setdefault(place.type, []).append(place)

    def any_place(self, *types: str) -> Place | None:
        places = [one for type in types for one in self.places.get(type, ())]
        return self.rng.choice(places) if places else None

    # expressions -----------------------------------------------------------------------------

    def constant(self) -> Value:
        type = self.rng.choice(INTEGERS)
        number = wrap(self.rng.choice([0, 1, -1, 2, 7, 100, 1 << 31, (1 << 63) - 1,
                                       self.rng.getrandbits(64)]), type)  # fmt: skip
        return Value(f"{type}#{number}", type, lambda env: number, True)

    def variable(self) -> Value:
        place = self.any_place(*INTEGERS)
        assert place is not None
        return place.value()

    def element(self) -> Value | None:
        """An element of an array, always inside."""
        arrays = [one for one in self.arrays if one[1] in WIDTHS]
        if not arrays:
            return None
        name, type, first, last, cells = self.rng.choice(arrays)
        index = self.variable()
        text = f"{name}[LIMIT(DINT#{first}, TO_DINT({index.text}), DINT#{last})]"

        def run(env: Env) -> Any:
            return cells(env)[min(max(wrap(index.run(env), "DINT"), first), last) - first].v

        return Value(text, type, run)

    def integer(self, depth: int = 3) -> Value:
        rng = self.rng
        if depth <= 0 or rng.random() < 0.15:
            kind = rng.random()
            if kind < 0.2:
                return self.constant()
            element = self.element() if kind < 0.4 else None
            return element or self.variable()
        make = rng.choice([self._two, self._two, self._two, self._shift, self._choice, self._one,
                           self._call, self._cast])  # fmt: skip
        return make(depth - 1)

    def _pair(self, depth: int) -> tuple[Value, Value]:
        left, right = self.integer(depth), self.integer(depth)
        return (self.variable() if left.is_constant and right.is_constant else left), right

    def _two(self, depth: int) -> Value:
        a, b = self._pair(depth)
        sign = self.rng.choice(["+", "-", "*", "/", "MOD", "AND", "OR", "XOR"])
        if sign == "/" and self.rng.random() < 0.9:
            number = self.rng.choice([1, 2, 3, 10])
            a = self.variable() if a.is_constant else a
            b = Value(f"DINT#{number}", "DINT", lambda env: number, True)
        if sign == "/" and b.is_constant and b.run({}) == 0:
            sign = "MOD"
        type = met(a.type, b.type)
        work: Callable[[int, int], int] = {
            "+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y,
            "/": quotient, "MOD": remainder, "AND": lambda x, y: x & y,
            "OR": lambda x, y: x | y, "XOR": lambda x, y: x ^ y,
        }[sign]  # fmt: skip

        def run(env: Env) -> int:
            return wrap(work(wrap(a.run(env), type), wrap(b.run(env), type)), type)

        return Value(f"({a.text} {sign} {b.text})", type, run)

    def _one(self, depth: int) -> Value:
        a = self.variable()
        kind = self.rng.choice(["NOT", "-", "ABS"])
        width = WIDTHS[a.type][0]
        if kind == "NOT":
            type = {8: "USINT", 16: "UINT", 32: "UDINT", 64: "ULINT"}[width]
            return Value(f"(NOT {a.text})", type, lambda env: wrap(~a.run(env), type))
        type = promoted(a.type)
        if kind == "ABS":
            return Value(f"ABS({a.text})", type, lambda env: wrap(abs(a.run(env)), type))
        type = {32: "DINT", 64: "LINT"}[max(width, 32)]
        return Value(f"(-{a.text})", type, lambda env: wrap(-a.run(env), type))

    def _shift(self, depth: int) -> Value:
        if self.rng.random() < 0.3:
            place = self.any_place(*BITS)
            if place is not None:
                return self._rotated(place)
        a, count = self.variable(), self.integer(depth)
        type = promoted(a.type)
        mask = WIDTHS[type][0] - 1
        left = self.rng.random() < 0.5

        def run(env: Env) -> int:
            value, by = a.run(env), count.run(env) & mask
            return wrap(value << by if left else value >> by, type)

        return Value(f"{'SHL' if left else 'SHR'}({a.text}, {count.text})", type, run)

    def _rotated(self, place: Place) -> Value:
        width = WIDTHS[place.type][0]
        by, left = self.rng.randint(0, 70), self.rng.random() < 0.5

        def run(env: Env) -> int:
            value: int = place.cell(env).v
            turn = (by if left else -by) % width
            return (value << turn | value >> (width - turn)) & (1 << width) - 1

        return Value(f"{'ROL' if left else 'ROR'}({place.text}, {by})", place.type, run)

    def _choice(self, depth: int) -> Value:
        a, b = self._pair(depth)
        kind = self.rng.choice(["MAX", "MIN", "SEL", "LIMIT", "MUX"])
        type = met(a.type, b.type)
        if kind in ("MAX", "MIN"):
            work = max if kind == "MAX" else min
            return Value(
                f"{kind}({a.text}, {b.text})", type,
                lambda env: work(wrap(a.run(env), type), wrap(b.run(env), type)),
            )  # fmt: skip
        if kind == "SEL":
            which = self.boolean(depth)

            def chosen(env: Env) -> int:
                test, no, yes = which.run(env), a.run(env), b.run(env)
                return wrap(yes if test else no, type)

            return Value(f"SEL({which.text}, {a.text}, {b.text})", type, chosen)
        c = self.variable()
        all_of_them = met(type, c.type)
        if kind == "LIMIT":
            return Value(
                f"LIMIT({a.text}, {b.text}, {c.text})", all_of_them,
                lambda env: _limited(*(wrap(one.run(env), all_of_them) for one in (a, b, c))),
            )  # fmt: skip
        index = self.integer(depth)

        def picked(env: Env) -> int:
            number = index.run(env)
            values = [wrap(one.run(env), all_of_them) for one in (a, b, c)]
            return values[number] if 0 <= number < 3 else values[2]

        return Value(f"MUX({index.text}, {a.text}, {b.text}, {c.text})", all_of_them, picked)

    def _call(self, depth: int) -> Value:
        if not self.functions:
            return self._two(depth)
        routine = self.rng.choice(self.functions)
        arguments = [self.argument(type, depth) for _, type in routine.parameters]
        named = self.rng.random() < 0.5
        texts = [
            f"{name} := {one.text}" if named else one.text
            for (name, _), one in zip(routine.parameters, arguments, strict=True)
        ]

        def run(env: Env) -> Any:
            values = [one.run(env) for one in arguments]
            return routine.called(values, [one.type for one in arguments], None)

        return Value(f"{routine.name}({', '.join(texts)})", routine.result, run)

    def argument(self, type: str, depth: int) -> Value:
        """What goes into a variable of a type."""
        if type in WIDTHS:
            return self.integer(depth)
        if type == "BOOL":
            return self.boolean(depth)
        if type in ("REAL", "LREAL"):
            return self.real(depth)
        return self.text(depth, type.startswith("W"))

    def _cast(self, depth: int) -> Value:
        type = self.rng.choice(INTEGERS)
        kind = self.rng.random()
        if kind < 0.25:
            a = self.boolean(depth)
            return Value(f"BOOL_TO_{type}({a.text})", type, lambda env: int(a.run(env)))
        if kind < 0.5:
            a = self.real(depth)
            return Value(f"TO_{type}({a.text})", type, lambda env: to_integer(a.run(env), type))
        if kind < 0.65:
            return self._measured(depth)
        a = self.integer(depth)
        a = self.variable() if a.is_constant else a
        return Value(f"TO_{type}({a.text})", type, lambda env: wrap(a.run(env), type))

    def boolean(self, depth: int = 3) -> Value:
        rng = self.rng
        place = self.any_place("BOOL")
        if place is not None and (depth <= 0 or rng.random() < 0.2):
            return place.value()
        kind = rng.random()
        if kind < 0.15:
            bits = self.any_place(*INTEGERS)
            assert bits is not None
            number = rng.randrange(WIDTHS[bits.type][0])
            return Value(
                f"{bits.text}.{number}", "BOOL", lambda env: bool(bits.cell(env).v >> number & 1)
            )
        if kind < 0.3:
            a, b = self.real(depth - 1), self.real(depth - 1)
            sign = rng.choice(list(_COMPARISONS))
            type = "LREAL" if "LREAL" in (a.type, b.type) else "REAL"
            return Value(
                f"({a.text} {sign} {b.text})", "BOOL",
                lambda env: _COMPARISONS[sign](
                    converted(a.run(env), a.type, type), converted(b.run(env), b.type, type)
                ),
            )  # fmt: skip
        if kind < 0.6:
            a, b = self._pair(depth - 1)
            sign, type = rng.choice(list(_COMPARISONS)), met(a.type, b.type)
            return Value(
                f"({a.text} {sign} {b.text})", "BOOL",
                lambda env: _COMPARISONS[sign](wrap(a.run(env), type), wrap(b.run(env), type)),
            )  # fmt: skip
        if kind < 0.7:
            wide, sign = rng.random() < 0.5, rng.choice(list(_COMPARISONS))
            one, other = self.text(depth - 1, wide), self.text(depth - 1, wide)
            return Value(
                f"({one.text} {sign} {other.text})", "BOOL",
                lambda env: _COMPARISONS[sign](
                    ordered(one.run(env), one.type), ordered(other.run(env), other.type)
                ),
            )  # fmt: skip
        if depth <= 0:
            return Value("TRUE", "BOOL", lambda env: True)
        a, b = self.boolean(depth - 1), self.boolean(depth - 1)
        sign = rng.choice(["AND", "OR", "XOR", "AND_THEN", "OR_ELSE", "NOT"])
        if sign == "NOT":
            return Value(f"(NOT {a.text})", "BOOL", lambda env: not a.run(env))
        return Value(f"({a.text} {sign} {b.text})", "BOOL", lambda env: _logic(sign, a, b, env))

    def real(self, depth: int = 2) -> Value:
        rng = self.rng
        place = self.any_place("REAL", "LREAL")
        assert place is not None
        if depth <= 0 or rng.random() < 0.3:
            return place.value()
        if rng.random() < 0.2:
            whole = self.any_place("SINT", "INT", "UINT", "BYTE")
            if whole is not None:
                type = rng.choice(["REAL", "LREAL"])
                return Value(f"TO_{type}({whole.text})", type, lambda env: float(whole.cell(env).v))
        a, b = self.real(depth - 1), self.real(depth - 1)
        type = "LREAL" if "LREAL" in (a.type, b.type) else "REAL"
        sign = rng.choice("+++---***/")
        exceptions = self.exceptions

        def run(env: Env) -> float:
            x, y = float(a.run(env)), float(b.run(env))
            if sign == "/":
                return divided(x, y, type, exceptions)
            result = x + y if sign == "+" else x - y if sign == "-" else x * y
            return real_result(result, (x, y), type, exceptions)

        return Value(f"({a.text} {sign} {b.text})", type, run)

    def text(self, depth: int = 2, wide: bool = False) -> Value:
        """A STRING or WSTRING, of up to 255 characters."""
        rng, w = self.rng, "W" if wide else ""
        type = f"{w}STRING(255)"
        place = self.any_place(f"{w}STRING(20)", f"{w}STRING(5)")
        if place is None or rng.random() < 0.2:
            letters = letters_of(rng, rng.randint(0, 8), wide)
            return Value(literal(letters, type), type, lambda env: letters)
        if depth <= 0 or rng.random() < 0.3:
            return place.value()
        if rng.random() < 0.1:
            return self._recoded(depth - 1, wide)
        a, b = self.text(depth - 1, wide), self.text(depth - 1, wide)
        n, m = rng.randint(-1, 9), rng.randint(-1, 9)
        choices: list[tuple[str, Callable[[str, str], str]]] = [
            (f"{w}CONCAT({a.text}, {b.text})", lambda x, y: x + y),
            (f"{w}LEFT({a.text}, {n})", lambda x, y: x[: max(n, 0)]),
            (f"{w}RIGHT({a.text}, {n})", lambda x, y: x[len(x) - min(max(n, 0), len(x)) :]),
            (f"{w}MID({a.text}, {n}, {m})",
             lambda x, y: x[m - 1 : m - 1 + n] if n > 0 and m > 0 else ""),
            (f"{w}DELETE({a.text}, {n}, {m})", lambda x, y: _without(x, n, m)),
            (f"{w}INSERT({a.text}, {b.text}, {n})", lambda x, y: _with(x, y, n)),
            (f"{w}REPLACE({a.text}, {b.text}, {n}, {m})",
             lambda x, y: _with(_without(x, n, m), y, max(m - 1, 0))),
        ]  # fmt: skip
        text, work = rng.choice(choices)
        needs_b = any(word in text[:8] for word in ("CONCAT", "INSERT", "REPLACE"))

        def run(env: Env) -> str:
            first = a.run(env)
            return work(first, b.run(env) if needs_b else "")[:255]

        return Value(text, type, run)

    def _recoded(self, depth: int, wide: bool) -> Value:
        """A text of the other kind."""
        a = self.text(depth, not wide)
        if wide:
            return Value(f"STRING_TO_WSTRING({a.text})", "WSTRING(255)", a.run)
        return Value(f"WSTRING_TO_STRING({a.text})", "STRING(255)", lambda env: narrow(a.run(env)))

    def _measured(self, depth: int) -> Value:
        """A number about texts."""
        wide = self.rng.random() < 0.5
        w, a = "W" if wide else "", self.text(depth, wide)
        if self.rng.random() < 0.5:
            return Value(f"{w}LEN({a.text})", "INT", lambda env: len(a.run(env)))
        b = self.text(depth - 1, wide)

        def run(env: Env) -> int:
            text, part = a.run(env), b.run(env)
            return text.find(part) + 1 if part else 0

        return Value(f"{w}FIND({a.text}, {b.text})", "INT", run)


def letters_of(rng: Random, count: int, wide: bool) -> str:
    """Letters that a STRING has, or a WSTRING."""
    return "".join(rng.choice("abcXYZ 019ä€ЖΩ中" if wide else "abcXYZ 019ä€") for _ in range(count))


def _without(text: str, length: int, position: int) -> str:
    if length <= 0 or position <= 0:
        return text
    return text[: position - 1] + text[position - 1 + length :]


def _with(text: str, other: str, position: int) -> str:
    return text[:position] + other + text[position:] if 0 <= position <= len(text) else text


_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": lambda x, y: x == y, "<>": lambda x, y: x != y, "<": lambda x, y: x < y,
    "<=": lambda x, y: x <= y, ">": lambda x, y: x > y, ">=": lambda x, y: x >= y,
}  # fmt: skip


def _limited(low: int, value: int, high: int) -> int:
    return min(max(value, low), high)


def _logic(sign: str, a: Value, b: Value, env: Env) -> bool:
    left: bool = a.run(env)
    if sign == "AND_THEN":
        return left and b.run(env)
    if sign == "OR_ELSE":
        return left or b.run(env)
    right: bool = b.run(env)
    return {"AND": left and right, "OR": left or right, "XOR": left != right}[sign]
