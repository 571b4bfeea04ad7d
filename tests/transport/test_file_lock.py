"""A file is held by one, until it is closed."""

from pathlib import Path

from achse.transport.file_lock import lock_file


def test_one_holds_it_until_it_is_closed(tmp_path: Path) -> None:
    place = tmp_path / "held"
    with place.open("w+") as first:
        assert lock_file(first)
        first.write("mine")
        first.flush()
        with place.open("r+") as second:
            assert not lock_file(second)
            assert second.read() == "mine"
    with place.open("r+") as third:
        assert lock_file(third)
