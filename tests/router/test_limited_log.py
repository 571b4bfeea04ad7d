"""Warnings that strangers can cause."""

import logging

from hypothesis import given
from hypothesis import strategies as st

from achse.router.limited_log import LimitedLog

SECOND = 1_000_000_000


class Recorded(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.messages.append(record.getMessage())


@given(
    st.lists(
        st.tuples(st.integers(0, 30), st.integers(0, 3 * SECOND), st.integers(1, 50)), max_size=30
    )
)
def test_warnings_keep_to_their_rate_and_each_one_left_out_is_counted(
    steps: list[tuple[int, int, int]],
) -> None:
    """Any clients at any times: a line for each warning, or a number in a later one."""
    log, records = logging.Logger("stranger"), Recorded()
    log.addHandler(records)
    now = caused = 0
    limited = LimitedLog(log, lambda: now)
    for client, pause, count in steps:
        now += pause
        before = len(records.messages)
        for _ in range(count):
            limited.warning(client, "refusing %d", client)
        caused += count
        assert len(records.messages) - before <= 3
    assert len(records.messages) <= 20 + 5 * now / SECOND + 1
    assert not records.messages or records.messages[0] == f"refusing {steps[0][0]}"
    left_out = [int(text.split("(")[1].split()[0]) for text in records.messages if "(" in text]
    assert all(number > 0 for number in left_out)
    assert len(records.messages) + sum(left_out) + limited._left_out == caused
