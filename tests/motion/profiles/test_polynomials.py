"""Polynomials by their coefficients."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from achse.motion.profiles.polynomials import derivative, evaluate

numbers = st.integers(-1000, 1000).map(float)


@given(st.lists(numbers, max_size=7), numbers)
def test_value_is_the_sum_of_powers(coefficients: list[float], x: float) -> None:
    exact = sum(Fraction(each) * Fraction(x) ** n for n, each in enumerate(coefficients))
    sizes = sum(abs(each * x**n) for n, each in enumerate(coefficients))
    assert abs(Fraction(evaluate(coefficients, x)) - exact) <= 1e-12 * sizes


@given(st.lists(numbers, max_size=7), st.integers(-100, 100))
def test_derivative_is_the_limit_of_differences(coefficients: list[float], x: int) -> None:
    """Exact in fractions: p(x + h) - p(x - h) over 2 h differs by terms of h² alone."""
    slope = Fraction(sum(Fraction(each) * x**n for n, each in enumerate(derivative(coefficients))))
    h = Fraction(1, 10**9)
    high, low = (
        sum(Fraction(each) * place**n for n, each in enumerate(coefficients))
        for place in (x + h, x - h)
    )
    assert abs((high - low) / (2 * h) - slope) < Fraction(1, 1000)
