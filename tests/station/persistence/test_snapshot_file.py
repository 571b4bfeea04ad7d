"""A snapshot file has the last snapshot or the one before it, wherever the power is cut."""

import contextlib
import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.persistence.snapshot_file import Snapshot, SnapshotFile, SnapshotFileError
from tests.station.persistence.failing_disk import FailingDisk, PowerCutError

PATH = Path("kept.snapshot")

contents = st.binary(max_size=40) | st.integers(0, 255).map(lambda n: bytes([n]) * 5000)
snapshots = st.builds(
    Snapshot,
    st.sampled_from([b"{}", b"x" * 4100]),
    contents,
    st.integers(-(1 << 63), (1 << 63) - 1),
)


def read(disk: FailingDisk) -> Snapshot | None:
    """What a process finds that starts now."""
    result = SnapshotFile(PATH, disk).read()
    return None if result is None else result[0]


@given(st.data())
def test_power_cut_leaves_the_last_snapshot_or_the_one_before(data: st.DataObject) -> None:
    """Any snapshots, processes and removals; cut in any operation, with any part of it written."""
    disk = FailingDisk()
    last: Snapshot | None = None
    for _ in range(data.draw(st.integers(1, 3), label="processes")):
        file = SnapshotFile(PATH, disk)
        for _ in range(data.draw(st.integers(1, 5), label="writes")):
            new = data.draw(st.none() | snapshots)
            disk.left = data.draw(st.none() | st.integers(0, 2))
            block = data.draw(st.sampled_from([1, 3, 512]))
            choice = data.draw(st.integers(0, (1 << 64) - 1))
            disk.mix = (
                lambda old, new, block=block, choice=choice: b"".join(  # type: ignore[misc]
                    (new if choice >> (at // block % 64) & 1 else old)[at : at + block]
                    for at in range(0, len(old), block)
                )
            )
            disk.is_kept = lambda choice=choice: bool(choice & 1)  # type: ignore[misc]
            try:
                if new is None:
                    file.remove()
                else:
                    file.write(new)
            except PowerCutError:
                snapshot = read(disk)
                assert snapshot in (last, new)
                last = snapshot
                break
            last = new
            assert read(disk) == last
        disk.left = None


def two_snapshots() -> tuple[FailingDisk, SnapshotFile, list[Snapshot]]:
    disk = FailingDisk()
    file = SnapshotFile(PATH, disk)
    written = [Snapshot(b"layout", bytes([n]) * 24, n) for n in range(3)]
    for each in written[:2]:
        file.write(each)
    return disk, file, written


def test_overwrite_cut_at_each_byte_leaves_the_one_before() -> None:
    for cut in range(57):
        disk, file, (_, last, new) = two_snapshots()
        disk.left, disk.mix = 0, lambda old, new, cut=cut: new[:cut] + old[cut:]  # type: ignore[misc]
        with pytest.raises(PowerCutError):
            file.write(new)
        snapshot = SnapshotFile(PATH, disk).read()
        if cut < 56:
            assert snapshot == (last, cut > 0)  # the first byte of the number differs
        else:
            assert snapshot == (new, False)


def test_file_cut_at_each_byte_has_a_whole_snapshot_or_is_refused() -> None:
    disk, _, (first, last, _) = two_snapshots()
    whole = disk.files[PATH]
    ends = 4096 + 56, 8192 + 56
    for length in [*range(80), *range(4090, 4160), *range(8180, 8260), len(whole)]:
        disk.files[PATH] = whole[:length]
        if length < ends[0]:
            with pytest.raises(SnapshotFileError):
                read(disk)
        else:
            expected = (first, True) if length < ends[1] else (last, False)
            assert SnapshotFile(PATH, disk).read() == expected


@given(st.binary(max_size=200), st.integers(0, 12288))
def test_any_bytes_are_refused_or_a_snapshot_that_was_written(part: bytes, offset: int) -> None:
    disk, _, (first, last, _) = two_snapshots()
    whole = disk.files[PATH]
    disk.files[PATH] = whole[:offset] + part + whole[offset + len(part) :]
    with contextlib.suppress(SnapshotFileError):
        assert read(disk) in (first, last)
    disk.files[PATH] = part
    with pytest.raises(SnapshotFileError):
        read(disk)


def test_snapshots_overwrite_in_place_and_another_layout_begins_a_file() -> None:
    disk, file, (first, _, last) = two_snapshots()
    assert disk.done == ["create", "replace", "overwrite"]
    size = len(disk.files[PATH])
    file.write(last)
    assert len(disk.files[PATH]) == size
    file.write(first._replace(layout=b"other"))
    file.write(first._replace(layout=b"other", content=b"longer" * 20))
    assert disk.done[3:] == ["overwrite", "create", "replace", "create", "replace"]
    del disk.files[PATH]
    file.write(first._replace(layout=b"other", content=b"longer" * 20))
    assert disk.done[8:] == ["create", "replace"], "a file that was removed is written again"


def test_after_an_error_the_snapshot_on_the_disk_stays() -> None:
    disk, file, (_, last, new) = two_snapshots()
    for _ in range(2):
        disk.error = errno.ENOSPC
        with pytest.raises(OSError, match="No space"):
            file.write(new)
        assert read(disk) == last
        disk.error = None
    file.write(new)
    assert read(disk) == new
    assert list(disk.files) == [PATH]


def test_file_on_the_disk_is_synchronised_before_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    for name in ("fsync", "replace"):
        real = getattr(os, name)

        def note(*words: object, name: str = name, real: Callable[..., object] = real) -> object:
            done.append(name)
            return real(*words)

        monkeypatch.setattr(os, name, note)
    monkeypatch.setattr("achse.station.persistence.file_port._sync_data", os.fsync)
    file = SnapshotFile(tmp_path / "a")
    written = [Snapshot(b"layout", bytes([n]) * 9000, n) for n in range(3)]
    for each in written:
        file.write(each)
        assert SnapshotFile(tmp_path / "a").read() == (each, False)
    assert done == ["fsync", "replace", "fsync", "fsync", "fsync"]
    assert [each.name for each in tmp_path.iterdir()] == ["a"]
    file.remove()
    file.remove()
    assert SnapshotFile(tmp_path / "a").read() is None
    assert list(tmp_path.iterdir()) == []


def test_what_may_never_end_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="not a regular file"):
        SnapshotFile(tmp_path / "pipe").read()
