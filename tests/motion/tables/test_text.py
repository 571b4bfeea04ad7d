"""Tables as text: what is read, what is written, what is wrong with them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.tables.function import MotionPoint
from achse.motion.tables.text import NAMES, TableTextError, content_of, text_of

NUMBER = st.floats(allow_nan=False, allow_infinity=False)
WORD = st.integers(0, 65535)


@pytest.mark.parametrize(
    "text",
    [
        "0 0\n1 0.10783\n",
        "# a cam\n0,0\n\n1,0.10783",
        "slave;master\n0;0\n0.10783;1\n",
        "Master;Slave;\n0;0;\n1;0,10783;\n",
        "0\t0\r\n1\t.10783",
        "0\t0\n1\t0,10783",
        "2\t2\n+0.00000\t+0.00000\n+1.00000\t+0.10783\n",
        "2 2\n0, 0\n1 , 0.10783",
    ],
)
def test_cams(text: str) -> None:
    assert content_of(text) == [(0.0, 0.0), (1.0, 0.10783)]


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("81 2\n82 1\n83 5", [(81.0, 2.0), (82.0, 1.0), (83.0, 5.0)]),
        ("2.0 2\n3 1\n4 5", [(2.0, 2.0), (3.0, 1.0), (4.0, 5.0)]),
        ("2,2\n3,1\n4,5", [(2.0, 2.0), (3.0, 1.0), (4.0, 5.0)]),
        ("2 2\n3 1\n4 5", [(3.0, 1.0), (4.0, 5.0)]),
    ],
)
def test_a_first_line_of_sizes_is_distinguished_from_a_row(
    text: str, rows: list[tuple[float, float]]
) -> None:
    assert content_of(text) == rows


def test_the_sample_of_the_manual() -> None:
    """004 §3.1.5: 81 rows, equidistant."""
    slaves = [0.0, 0.10783, 0.43114, *(4.0 * n for n in range(3, 80)), 279.72]
    text = "81\t2\n" + "".join(f"{n:+.5f}\t{slave:+.5f}\n" for n, slave in enumerate(slaves))
    content = content_of(text)
    assert len(content) == 81
    assert (content[1], content[-1]) == ((1.0, 0.10783), (80.0, 279.72))


def test_motion_functions() -> None:
    begin, end = content_of("master,slave,law\n0,0,12\n90,30,1\n")
    assert begin == MotionPoint(function_type=12)
    assert end == MotionPoint(function_type=1, master_position=90.0, slave_position=30.0)
    first = content_of("2 6\n0 0 15 0.5 0.25 0.125\n90 30 0 0 0 0\n")[0]
    assert first == MotionPoint(0, 15, 0, 1, 0, 0.0, 0.0, 0.5, 0.25, 0.125)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 0, "expected 2 rows or more, got 0"),
        ("1 2", 0, "expected 2 rows or more, got 1"),
        ("2 2", 1, "expected 2 rows as it says, got 0"),
        ("1.0 2", 0, "expected 2 rows or more, got 1"),
        ("master,slave", 0, "expected 2 rows or more, got 0"),
        ("a b c", 1, "expected columns of master, slave"),
        ("master master slave", 1, "expected columns of master, slave"),
        ("0 0\n1 x\n", 2, "expected numbers, got '1 x'"),
        ("0 0\n1 nan\n", 2, "expected numbers"),
        ("0 0\n1 inf\n", 2, "expected numbers"),
        ("0 0\n1 1e999\n", 2, "expected numbers"),
        ("0 0\n1 1_0\n", 2, "expected numbers"),
        ("0,,0\n1,1\n", 1, "expected numbers"),
        ("0 0\n1 2 3\n", 2, "expected 2 numbers, got 3"),
        ("0 0 1.5\n1 1 1\n", 1, "law 1.5, expected 0..65535"),
        ("0 0 -1\n1 1 1\n", 1, "law -1, expected"),
        ("master,slave,type\n0,0,65536\n1,1,0\n", 2, "type 65536, expected"),
        ("1\n2\n", 1, "expected 2 numbers, got 1"),
        ("0 0 0 0 0 0 0 0\n1 1 1 1 1 1 1 1\n", 1, "expected 2 numbers, or up to 7, got 8"),
        ("81 2\n0 0\n1 1\n", 1, "expected 81 rows as it says, got 2"),
        ("2 2\n0 0 5\n1 1 5\n", 2, "expected 2 numbers, got 3"),
        ("2 1\n0\n1\n", 2, "expected 2 numbers, got 1"),
    ],
)
def test_what_is_no_table(text: str, line: int, message: str) -> None:
    with pytest.raises(TableTextError, match=message) as caught:
        content_of(text)
    assert caught.value.line == line


@given(st.text(st.sampled_from("0123456789 .,;+-e\n\t#master_nif\0é"), max_size=60))
def test_any_text_is_a_table_or_an_error(text: str) -> None:
    try:
        content = content_of(text)
    except TableTextError:
        return
    assert len(content) > 1


@given(st.lists(st.tuples(NUMBER, NUMBER), min_size=2, max_size=9))
def test_a_cam_is_read_as_it_was_written(rows: list[tuple[float, float]]) -> None:
    assert content_of(text_of(rows)) == rows


@given(
    st.lists(
        st.builds(
            MotionPoint,
            *(st.just(0), WORD, WORD, st.just(1), st.just(0)),
            *(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER),
        ),
        min_size=2,
        max_size=9,
    )
)
def test_a_motion_function_is_read_as_it_was_written(points: list[MotionPoint]) -> None:
    text = text_of(points)
    assert content_of(text) == points
    assert text.splitlines()[0] == ",".join(NAMES)
