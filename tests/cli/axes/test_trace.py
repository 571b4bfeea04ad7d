"""A trace keeps what matters of each sample."""

from achse.cli.axes.trace import COLUMNS, Trace


def _values(position: float) -> dict[str, float]:
    return dict.fromkeys(COLUMNS, 0.0) | {"actual_position": position, "state_dword": 1}


def _trace() -> Trace:
    trace = Trace("mm")
    for n in range(5):
        trace.add(133_000_000_000_000_000 + n * 100_000, _values(float(-n)))
    return trace


def test_times_are_seconds_since_the_first_sample() -> None:
    assert _trace().times == [0.0, 0.01, 0.02, 0.03, 0.04]


def test_columns_and_their_peaks() -> None:
    trace = _trace()
    assert trace["actual_position"] == [0.0, -1.0, -2.0, -3.0, -4.0]
    assert trace.peak("actual_position") == 4.0
    assert Trace("mm").peak("actual_position") == 0.0


def test_what_is_old_is_dropped() -> None:
    trace = _trace()
    trace.keep_since(0.03)
    assert (trace.times, trace["actual_position"]) == ([0.03, 0.04], [-3.0, -4.0])
    trace.keep_since(1.0)
    assert trace.times == []


def test_the_picture_has_position_above_velocity() -> None:
    trace = _trace()
    titles = [line.strip() for line in trace.lines(60) if "mm" in line]
    assert titles == ["position mm", "velocity mm/s"]
    text = trace.text(60)
    assert text.plain.splitlines() == trace.lines(60)
    assert {str(span.style) for span in text.spans} == {"dim", "cyan"}
