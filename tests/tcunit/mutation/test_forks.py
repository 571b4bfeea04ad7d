"""Work in copies of this process: results, failures, limits, and nothing left behind."""

import os
import signal

import pytest

from achse.tcunit.mutation.forks import CAN_FORK, in_copies

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="a process cannot be copied here")


def _fails() -> None:
    raise ValueError("no")


def _is_killed() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _endless() -> None:
    while True:
        pass


@pytest.mark.parametrize("jobs", [1, 3])
def test_each_copy_has_its_own_memory(jobs: int) -> None:
    seen: list[int] = []

    def work(number: int) -> list[int]:
        seen.append(number)
        return seen * 20_000  # more than a pipe holds

    works = [lambda number=number: work(number) for number in range(7)]
    results = dict(in_copies(works, jobs, 10.0))
    assert sorted(results) == list(range(7))
    assert all(one.value == [number] * 20_000 for number, one in results.items())
    assert seen == []


def test_what_does_not_return() -> None:
    results = dict(in_copies([_fails, _is_killed, lambda: os._exit(3)], 1, 10.0))
    assert results[0].problem == "ValueError: no"
    assert results[1].problem == "ended by signal 9"
    assert results[2].problem == "ended with code 3"
    assert not any(one.is_out_of_time for one in results.values())


def test_what_takes_too_long_is_ended() -> None:
    ((_, results),) = in_copies([_endless], 1, 0.01)
    assert results.is_out_of_time


def test_no_copy_outlives_its_caller() -> None:
    reader, writer = os.pipe()

    def waits() -> None:
        os.write(writer, str(os.getpid()).encode())
        signal.pause()

    results = in_copies([lambda: 1, waits], 2, 10.0)
    assert next(results)[1].value == 1
    process = int(os.read(reader, 20))
    results.close()  # type: ignore[attr-defined]
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
    os.close(reader)
    os.close(writer)
