"""Checks that run beside the collection: their results are read, and made where there are none."""

import os

import pytest

from tests import background

CHECK = {"check": ["true"]}


@pytest.fixture
def pipe(monkeypatch: pytest.MonkeyPatch) -> int:
    """The writing end of the pipe of a check."""
    ours, theirs = os.pipe()
    monkeypatch.setattr(background, "CHECKS", CHECK)
    monkeypatch.setenv(background.RESULTS, f"check={ours}")
    monkeypatch.setattr(background, "run_check", lambda command: (0, f"ran {command[0]}"))
    return theirs


def test_result_comes_through_the_pipe(pipe: int) -> None:
    os.write(pipe, b"3\nfirst\nsecond")
    os.close(pipe)
    assert background.result_of("check") == (3, "first\nsecond")


def test_check_without_a_result_is_run(pipe: int) -> None:
    os.close(pipe)
    assert background.result_of("check") == (0, "ran true")


def test_check_without_a_pipe_is_run(pipe: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(background.RESULTS)
    assert background.result_of("check") == (0, "ran true")


def test_ended_background_gives_no_results_and_ends_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(background.RESULTS, "")  # that of the run comes back
    process = background.Background(("none",))
    assert background.RESULTS in os.environ
    process.end()
    process.end()
    assert background.RESULTS not in os.environ
    assert process.process.returncode
