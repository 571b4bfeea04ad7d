"""Arithmetic written in a configuration: numbers, the time, variables, a fixed set of functions.

Nothing of Python can be reached from it. The text is parsed here and becomes a tree of functions.
"""

import math
import operator
import re
from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import NamedTuple, NoReturn

LONGEST = 1000
"""Characters of an expression."""

_DEEPEST = 50
"""Parentheses within parentheses."""

Value = Callable[[float], float]
"""Value of a part of an expression at a time in seconds."""


class ExpressionError(ValueError):
    """An expression cannot be read; says where, what was expected and what came."""


class FormulaFunction(NamedTuple):
    """A function of expressions, and how many arguments it takes; None for one or more."""

    compute: Callable[..., float]
    takes: int | None
    meaning: str


def _sign(value: float) -> float:
    return float((value > 0) - (value < 0))


def _limit(low: float, value: float, high: float) -> float:
    return min(max(value, low), high)


def _choose(condition: float, then: float, otherwise: float) -> float:
    return then if condition else otherwise


FUNCTIONS: Mapping[str, FormulaFunction] = {
    "sin": FormulaFunction(math.sin, 1, "sine of radians"),
    "cos": FormulaFunction(math.cos, 1, "cosine of radians"),
    "tan": FormulaFunction(math.tan, 1, "tangent of radians"),
    "asin": FormulaFunction(math.asin, 1, "arc sine, radians"),
    "acos": FormulaFunction(math.acos, 1, "arc cosine, radians"),
    "atan": FormulaFunction(math.atan, 1, "arc tangent, radians"),
    "atan2": FormulaFunction(math.atan2, 2, "angle of y, x, radians"),
    "sqrt": FormulaFunction(math.sqrt, 1, "square root"),
    "exp": FormulaFunction(math.exp, 1, "power of e"),
    "ln": FormulaFunction(math.log, 1, "natural logarithm"),
    "log": FormulaFunction(math.log10, 1, "logarithm to base 10"),
    "abs": FormulaFunction(abs, 1, "without sign"),
    "sign": FormulaFunction(_sign, 1, "-1, 0 or 1"),
    "floor": FormulaFunction(lambda x: float(math.floor(x)), 1, "next whole number below"),
    "ceil": FormulaFunction(lambda x: float(math.ceil(x)), 1, "next whole number above"),
    "round": FormulaFunction(lambda x: float(round(x)), 1, "nearest whole number"),
    "trunc": FormulaFunction(lambda x: float(math.trunc(x)), 1, "without what is behind the point"),
    "min": FormulaFunction(min, None, "the smallest"),
    "max": FormulaFunction(max, None, "the largest"),
    "limit": FormulaFunction(_limit, 3, "low, value, high: the value within the two"),
    "if": FormulaFunction(_choose, 3, "condition, then, otherwise"),
}
CONSTANTS = {"pi": math.pi, "true": 1.0, "false": 0.0}


class _Token(StrEnum):
    END = ""
    NUMBER = "number"
    NAME = "name"
    SIGN = "sign"
    UNKNOWN = "unknown"


_TOKEN = re.compile(
    r"""\s*(?:
        (?P<number>(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
      | (?P<name>[^\W\d]\w*(?:\s*\[\s*-?\d+(?:\s*,\s*-?\d+)*\s*\])*
                (?:\.\w+(?:\s*\[\s*-?\d+(?:\s*,\s*-?\d+)*\s*\])*)*)
      | (?P<sign>\*\*|<=|>=|<>|==|!=|[-+*/%^()<>=,])
    )""",
    re.VERBOSE,
)

_COMPARISONS: Mapping[str, Callable[[float, float], bool]] = {
    "=": operator.eq,
    "==": operator.eq,
    "<>": operator.ne,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_WORDS = {"and", "or", "not", "mod", "xor"}


class Formula(NamedTuple):
    """Parsed expression: its value at a time in seconds, and the variables it names."""

    value: Value
    names: tuple[str, ...]


def parse_expression(text: str, variable: Callable[[str], Callable[[], float]]) -> Formula:
    """Read `text`; `variable` gives what reads a name that is not ours, or raises ValueError.

    Operators, weakest first: OR XOR, AND, NOT, = <> < <= > >=, + -, * / MOD, sign, ** (or ^);
    comparisons give 0 or 1. `t` is the time in seconds. Raises ExpressionError.

    A value that cannot be computed raises ArithmeticError or ValueError when it is asked for.
    """
    if len(text) > LONGEST:
        raise ExpressionError(f"an expression has up to {LONGEST} characters, got {len(text)}")
    return _Parser(text, variable).whole()


class _Parser:
    def __init__(self, text: str, variable: Callable[[str], Callable[[], float]]) -> None:
        self._text = text
        self._variable = variable
        self._names: list[str] = []
        self._depth = 0
        self._at = 0
        self._kind, self._word = _Token.END, ""
        self._next()

    def whole(self) -> Formula:
        value = self._disjunction()
        if self._kind:
            self._fault("an operator or the end")
        return Formula(value, tuple(dict.fromkeys(self._names)))

    # tokens ----------------------------------------------------------------------------------

    def _next(self) -> str:
        """Go on to the next token; gives the one that was there."""
        before = self._word
        self._begin = self._at + len(self._text[self._at :]) - len(self._text[self._at :].lstrip())
        match = _TOKEN.match(self._text, self._at)
        if match is None:
            if self._text[self._at :].strip():
                self._kind, self._word = _Token.UNKNOWN, self._text[self._begin]
            else:
                self._kind, self._word = _Token.END, ""
            return before
        self._kind = _Token(match.lastgroup or "")
        self._word = match[self._kind]
        self._at = match.end()
        if self._kind is _Token.NAME and self._word.lower() in _WORDS:
            self._kind, self._word = _Token.SIGN, self._word.lower()
        return before

    def _fault(self, expected: str) -> NoReturn:
        got = repr(self._word) if self._kind else "the end"
        raise ExpressionError(f"column {self._begin + 1}: expected {expected}, got {got}")

    def _is_sign(self, *words: str) -> bool:
        return self._kind is _Token.SIGN and self._word in words

    def _takes(self, *words: str) -> str:
        """Return the sign that is next, if it is one of these; then it is taken."""
        if self._is_sign(*words):
            return self._next()
        return ""

    # grammar ---------------------------------------------------------------------------------

    def _disjunction(self) -> Value:
        left = self._conjunction()
        while word := self._takes("or", "xor"):
            left = _pair(left, self._conjunction(), _either if word == "or" else _one_of)
        return left

    def _conjunction(self) -> Value:
        left = self._negation()
        while self._takes("and"):
            left = _pair(left, self._negation(), _both)
        return left

    def _negation(self) -> Value:
        if self._takes("not"):
            value = self._deeper(self._negation)
            return lambda t: float(not value(t))
        return self._comparison()

    def _comparison(self) -> Value:
        left = self._sum()
        while word := self._takes(*_COMPARISONS):
            left = _pair(left, self._sum(), _COMPARISONS[word])
        return left

    def _sum(self) -> Value:
        left = self._product()
        while word := self._takes("+", "-"):
            left = _pair(left, self._product(), operator.add if word == "+" else operator.sub)
        return left

    def _product(self) -> Value:
        left = self._signed()
        while word := self._takes("*", "/", "%", "mod"):
            compute = {"*": operator.mul, "/": operator.truediv}.get(word, math.fmod)
            left = _pair(left, self._signed(), compute)
        return left

    def _signed(self) -> Value:
        if word := self._takes("-", "+"):
            value = self._deeper(self._signed)
            return value if word == "+" else lambda t: -value(t)
        return self._power()

    def _power(self) -> Value:
        base = self._atom()
        if self._takes("**", "^"):
            return _pair(base, self._deeper(self._signed), math.pow)
        return base

    def _deeper(self, read: Callable[[], Value]) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ExpressionError(f"it nests deeper than {_DEEPEST} levels")
        value = read()
        self._depth -= 1
        return value

    def _atom(self) -> Value:
        if self._kind is _Token.NUMBER:
            number = float(self._next().replace("_", ""))
            return lambda t: number
        if self._takes("("):
            value = self._deeper(self._disjunction)
            if not self._takes(")"):
                self._fault("')'")
            return value
        if self._kind is not _Token.NAME:
            self._fault("a number, a name or '('")
        name = self._next()
        if self._is_sign("("):
            return self._call(name)
        if name.lower() == "t":
            return lambda t: t
        if name.lower() in CONSTANTS:
            constant = CONSTANTS[name.lower()]
            return lambda t: constant
        self._names.append(name)
        try:
            read = self._variable(name)
        except ExpressionError:
            raise
        except ValueError as fault:
            raise ExpressionError(str(fault)) from None
        return lambda t: read()

    def _call(self, name: str) -> Value:
        function = FUNCTIONS.get(name.lower())
        if function is None:
            raise ExpressionError(f"no function {name}; there are {', '.join(FUNCTIONS)}")
        self._next()
        arguments = [self._deeper(self._disjunction)]
        while self._takes(","):
            arguments.append(self._deeper(self._disjunction))
        if not self._takes(")"):
            self._fault("',' or ')'")
        if function.takes not in (None, len(arguments)):
            raise ExpressionError(
                f"{name} takes {function.takes} arguments ({function.meaning}), got"
                f" {len(arguments)}"
            )
        compute = function.compute
        if len(arguments) == 1:
            [only] = arguments
            if function.takes is None:  # min and max of one value
                return only
            return lambda t: compute(only(t))
        return lambda t: compute(*[argument(t) for argument in arguments])


def _pair(left: Value, right: Value, compute: Callable[[float, float], float]) -> Value:
    return lambda t: float(compute(left(t), right(t)))


def _both(a: float, b: float) -> float:
    return float(bool(a) and bool(b))


def _either(a: float, b: float) -> float:
    return float(bool(a) or bool(b))


def _one_of(a: float, b: float) -> float:
    return float(bool(a) is not bool(b))
