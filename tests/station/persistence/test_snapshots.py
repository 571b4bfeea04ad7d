"""Snapshots are written when something has changed, and trouble of the disk stops nothing."""

import asyncio
import errno
import logging
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.persistence.persistent_image import (
    PersistentImage,
    PersistentLayout,
    PersistentValues,
)
from achse.station.persistence.snapshot_file import SnapshotFile
from achse.station.persistence.snapshots import Snapshots
from tests.station.persistence.failing_disk import FailingDisk

LAYOUT = PersistentLayout.of(None, {}, PersistentValues())
INTERVAL_S = 0.1


def image(value: int) -> PersistentImage:
    return PersistentImage(LAYOUT, bytes([value]), value)


class Computer:
    """A computer's time and disk. `turn(number)` is what happens in each pause."""

    def __init__(self, turn: Callable[[int], None], count: int) -> None:
        self.disk = FailingDisk()
        self.now = 0.0
        self.pauses: list[float] = []
        self.file = SnapshotFile(Path("a"), self.disk)
        self.snapshots = Snapshots(self.file, INTERVAL_S, lambda: self.now, self.sleep)
        self._turn, self._count = turn, count

    async def sleep(self, seconds: float) -> None:
        self.pauses.append(seconds)
        if len(self.pauses) > self._count:
            raise asyncio.CancelledError
        self.now += seconds
        self._turn(len(self.pauses))

    def run(self, capture: Callable[[], PersistentImage | None]) -> None:
        with pytest.raises(asyncio.CancelledError):
            asyncio.run(self.snapshots.run(capture))

    @property
    def written(self) -> int | None:
        result = SnapshotFile(Path("a"), self.disk).read()
        return None if result is None else result[0].content[0]


@given(st.lists(st.none() | st.integers(0, 3), min_size=1, max_size=12), st.none() | st.just(0))
def test_snapshot_is_written_when_the_image_has_changed(
    values: list[int | None], begin: int | None
) -> None:
    """Once each interval; not while there is nothing to write; not what the files have already."""
    computer = Computer(lambda _: None, len(values))
    if begin is not None:
        computer.snapshots.begin_with(image(begin))
    rest = iter(values)

    def capture() -> PersistentImage | None:
        value = next(rest)
        return None if value is None else image(value)

    computer.run(capture)
    last, changes = begin, 0
    for value in values:
        changes += value not in (None, last)
        last = last if value is None else value
    done = computer.disk.done
    assert done.count("create") + done.count("overwrite") == changes
    assert computer.written == (last if changes else None)
    assert set(computer.pauses) == {INTERVAL_S}


@given(
    st.lists(st.sampled_from([None, errno.ENOSPC, errno.EROFS, errno.EIO]), max_size=8),
)
def test_trouble_of_the_disk_is_reported_once_and_ends(errors: list[int | None]) -> None:
    lines: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    """However often it comes and goes meanwhile, as at the limit of file descriptors."""
    turns = len(errors) + 1 + int(30 / INTERVAL_S) + 1
    values = iter([*range(len(errors) + 1), *[len(errors)] * turns])

    def turn(number: int) -> None:
        computer.disk.error = dict(enumerate(errors, 1)).get(number)

    computer = Computer(turn, turns)
    logging.getLogger("achse.station").addHandler(handler)
    try:
        computer.run(lambda: image(next(values)))
    finally:
        logging.getLogger("achse.station").removeHandler(handler)
    assert computer.written == len(errors)
    count = len(errors) - errors.count(None)
    assert len(lines) == 2 * bool(count)
    if lines:
        assert lines[0].startswith("a cannot be written: ")
        assert lines[1] == f"a is written again; {count} writes failed"
    paused = [INTERVAL_S, *(1.0 if error else INTERVAL_S for error in [*errors, None])]
    assert computer.pauses[: len(paused)] == paused


def test_slow_disk_is_reported_once_and_has_pauses(caplog: pytest.LogCaptureFixture) -> None:
    values = iter([1, 2, 3, 4])
    took = iter([3.0, 2.0, 0.01, 5.0])
    computer = Computer(lambda _: None, 4)
    write = computer.file.write

    def write_slowly(snapshot: object) -> None:
        write(snapshot)  # type: ignore[arg-type]
        computer.now += next(took)

    computer.file.write = write_slowly  # type: ignore[method-assign]
    computer.run(lambda: image(next(values)))
    assert computer.pauses == pytest.approx([0.1, 3.0, 2.0, 0.09, 5.0])
    assert [record.getMessage() for record in caplog.records] == [
        "a: writing took 3.0 s, expected up to 1 s; a power cut loses so much"
    ]


def test_images_that_cost_much_are_taken_less_often() -> None:
    computer = Computer(lambda _: None, 2)

    def capture() -> PersistentImage:
        computer.now += 0.02
        return image(1)

    computer.run(capture)
    assert computer.pauses == pytest.approx([0.1, 0.4, 0.4])


def test_image_from_before_a_save_is_not_written_after_it() -> None:
    computer = Computer(lambda _: None, 1)
    snapshots = computer.snapshots
    assert snapshots.write(image(1), 0)
    assert computer.written == 1
    saved: list[int] = []
    snapshots.supersede(image(3), lambda: saved.append(3))
    assert (saved, computer.written) == ([3], None)
    assert snapshots.write(image(2), 0), "a thread that was late"
    assert computer.written is None
    computer.run(lambda: image(3))
    assert computer.written is None, "the other file has it"
    assert snapshots.write(image(4), 1)
    assert computer.written == 4


def test_save_that_fails_leaves_the_snapshot() -> None:
    computer = Computer(lambda _: None, 1)
    assert computer.snapshots.write(image(1))

    def fail() -> None:
        raise OSError(errno.ENOSPC, "full")

    with pytest.raises(OSError, match="full"):
        computer.snapshots.supersede(image(2), fail)
    assert computer.written == 1


def test_start_after_a_failed_write_is_written() -> None:
    """A restart on a full disk: what the axes were left with is in no file yet."""
    computer = Computer(lambda _: None, 1)
    computer.disk.error = errno.ENOSPC
    assert not computer.snapshots.write(image(5))
    computer.snapshots.begin_with(image(5))
    computer.disk.error = None
    computer.run(lambda: image(5))
    assert computer.written == 5
