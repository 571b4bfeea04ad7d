"""Elements: all laws of motion in one form, as numbers that plain and compiled kernels walk.

An element is a polynomial and two sines over the master: with w = (master - BEGIN) · RATE the slave
is at Σ coefficient[k] wᵏ + SIZE sin(TURN w + LEAD) + SECOND_SIZE sin(SECOND_TURN w + SECOND_LEAD).
It is `ELEMENT` numbers, and holds from its begin to that of the next. A segment of a motion
function is one element or several; the last element of a function is the position at rest.

Kernel source: `element_at` and `element_values` are compiled as they stand.
"""

from array import array
from collections.abc import Iterator, Sequence
from math import cos, floor, sin

BEGIN = 0
RATE = 1
DEGREE = 2
"""Of the polynomial; coefficients above are 0."""
SIZE = 3
TURN = 4
LEAD = 5
SECOND_SIZE = 6
SECOND_TURN = 7
SECOND_LEAD = 8
COEFFICIENT = 9
"""The first of ten."""

COEFFICIENTS = 10
"""Of a polynomial of the ninth degree."""

ELEMENT = COEFFICIENT + COEFFICIENTS
"""Numbers of one element."""


def element_at(numbers: Sequence[float], first: int, count: int, near: int, place: float) -> int:
    """Return the index of the element at `place`, the first one being at number `first`.

    `near` is the index to try first. The end of the last element is still within it.
    """
    if near >= 0 and near < count - 1:
        at = first + ELEMENT * near
        if numbers[at + BEGIN] <= place and place < numbers[at + ELEMENT + BEGIN]:
            return near
    low = 0
    high = count
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[first + ELEMENT * middle + BEGIN] <= place:
            low = middle
        else:
            high = middle
    if count > 1 and low == count - 1 and numbers[first + ELEMENT * low + BEGIN] == place:
        low -= 1
    return low


def element_values(
    numbers: Sequence[float], at: int, place: float
) -> tuple[float, float, float, float]:
    """Slave position and its first three derivatives by the master, of the element at number `at`.

    Before its begin an element has its first position.
    """
    rate = numbers[at + RATE]
    w = (place - numbers[at + BEGIN]) * rate
    if w < 0.0:
        w = 0.0
        rate = 0.0
    s = 0.0
    v = 0.0
    a = 0.0
    j = 0.0
    for k in range(floor(numbers[at + DEGREE]), -1, -1):  # Horner, and its derivatives
        j = j * w + a
        a = a * w + v
        v = v * w + s
        s = s * w + numbers[at + COEFFICIENT + k]
    a *= 2.0
    j *= 6.0
    for n in range(2):
        sine = at + SIZE + 3 * n
        size = numbers[sine]
        if size != 0.0:
            turn = numbers[sine + 1]
            lead = numbers[sine + 2]
            up = size * sin(turn * w + lead)
            slope = size * turn * cos(turn * w + lead)
            s += up
            v += slope
            a -= turn * turn * up
            j -= turn * turn * slope
    return s, rate * v, rate * rate * a, rate * rate * rate * j


def make_element(
    begin: float,
    rate: float,
    coefficients: Sequence[float],
    sine: Sequence[float] = (0.0, 0.0, 0.0),
    second: Sequence[float] = (0.0, 0.0, 0.0),
) -> "array[float]":
    """Return the numbers of an element; a sine is its size, turn and lead."""
    rest = [0.0] * (COEFFICIENTS - len(coefficients))
    degree = max(len(coefficients) - 1, 0)
    return array("d", (begin, rate, degree, *sine, *second, *coefficients, *rest))


def elements_of(numbers: "array[float]") -> "Iterator[array[float]]":
    """Return each element of a function by itself."""
    for at in range(0, len(numbers), ELEMENT):
        yield numbers[at : at + ELEMENT]
