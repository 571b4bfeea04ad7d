"""Ways over a master: the worked numbers, and exact arithmetic as the judge."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.couplings.flying_saws.approach import line, place_at, quintic, ramp, weak_ramp


def fifth(height: float, length: float, slope: float, bend: float, end: float) -> list[float]:
    terms = [0.0] * 6
    quintic(terms, 0, length, 0.0, height, slope, bend, end)
    return terms


@pytest.mark.parametrize(
    ("slave", "slope", "length", "height", "gear", "way", "place", "velocity"),
    [
        (20.0, 0.0, 200.0, 100.0, 1.0, 50.0, 22.734375, 0.15625),
        (20.0, 0.0, 200.0, 100.0, 1.0, 100.0, 38.75, 0.5),
        (20.0, 0.0, 200.0, 100.0, 1.0, 150.0, 72.734375, 0.84375),
        (20.0, 0.25, 160.0, 130.0, 1.25, 40.0, 33.22265625, 0.47216796875),
        (20.0, 0.25, 160.0, 130.0, 1.25, 80.0, 60.0, 0.8671875),
        (20.0, 0.25, 160.0, 130.0, 1.25, 120.0, 101.15234375, 1.15966796875),
    ],
)
def test_worked_numbers_of_the_universal_saw(
    slave: float, slope: float, length: float, height: float, gear: float,
    way: float, place: float, velocity: float,
) -> None:  # fmt: skip
    s, d1, _, _ = place_at(fifth(height, length, slope, 0.0, gear), 0, length, way / length)
    assert slave + s == pytest.approx(place, abs=1e-12)
    assert d1 == pytest.approx(velocity, abs=1e-12)


@pytest.mark.parametrize(("smooth", "place"), [(False, 12.5), (True, 9.375)])
def test_worked_numbers_of_the_weak_saw(smooth: bool, place: float) -> None:
    """k = 2, 50 of the master; in the middle the velocity is that of the master."""
    terms = [0.0] * 6
    weak_ramp(terms, 0, 50.0, 2.0, smooth)
    assert place_at(terms, 0, 50.0, 0.5)[:2] == pytest.approx((place, 1.0), abs=1e-12)
    assert place_at(terms, 0, 50.0, 1.0)[:2] == pytest.approx((50.0, 2.0), abs=1e-12)


REAL = st.floats(-1e3, 1e3, allow_subnormal=False)


def solved(length: Fraction, ends: list[Fraction]) -> list[Fraction]:
    """Terms of the polynomial with these values, slopes and bends at 0 and 1, by elimination."""
    rows = []
    for u in (0, 1):
        for order in range(3):
            row = []
            for power in range(6):
                factor = 1
                for k in range(order):
                    factor *= power - k
                row.append(Fraction(0 if power < order else factor * u ** (power - order)))
            rows.append([*row, ends[3 * u + order] * length**order])
    for column in range(6):
        pivot = next(r for r in range(column, 6) if rows[r][column])
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [each / rows[column][column] for each in rows[column]]
        for r in range(6):
            if r != column:
                times = rows[r][column]
                rows[r] = [a - times * b for a, b in zip(rows[r], rows[column], strict=True)]
    return [row[6] for row in rows]


@given(
    REAL, st.floats(0.01, 1e3), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0),
    st.floats(-10.0, 10.0), st.floats(0.0, 1.0),
)  # fmt: skip
def test_the_fifth_degree_is_that_of_exact_arithmetic(
    height: float, length: float, slope: float, bend: float, end: float, u: float
) -> None:
    exact = [Fraction(each) for each in (0.0, slope, bend, height, end, 0.0)]
    wanted = solved(Fraction(length), exact)
    terms = fifth(height, length, slope, bend, end)
    scale = max(abs(float(term)) for term in wanted) + 1e-9
    assert terms == pytest.approx([float(term) for term in wanted], abs=1e-12 * scale)
    at = Fraction(u)
    s, d1, d2, d3 = place_at(terms, 0, length, u)
    for order, value in enumerate((s, d1, d2, d3)):
        total = Fraction(0)
        for power in range(order, 6):
            factor = 1
            for k in range(order):
                factor *= power - k
            total += factor * wanted[power] * at ** (power - order)
        expected = float(total / Fraction(length) ** order)
        assert value == pytest.approx(expected, abs=1e-10 * scale / length**order)


@given(REAL, st.floats(0.01, 1e3), st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))
def test_ramps_and_lines_join_without_a_jump(
    begin: float, length: float, slope: float, end: float
) -> None:
    terms = [0.0] * 12
    ramp(terms, 0, length, begin, slope, end)
    line(terms, 6, length, begin + 0.5 * (slope + end) * length, end)
    assert place_at(terms, 0, length, 0.0)[:3] == pytest.approx((begin, slope, 0.0))
    before, after = place_at(terms, 0, length, 1.0), place_at(terms, 6, length, 0.0)
    assert before[:3] == pytest.approx(after[:3], abs=1e-9)
