"""Polynomials by their coefficients, that of the lowest power first."""

from collections.abc import Sequence


def derivative(coefficients: Sequence[float]) -> list[float]:
    """Return the coefficients of the derivative."""
    return [power * each for power, each in enumerate(coefficients)][1:]


def evaluate(coefficients: Sequence[float], x: float) -> float:
    """Return the value at `x`."""
    value = 0.0
    for each in reversed(coefficients):
        value = value * x + each
    return value
