"""State files are replaced whole, and a file that is not there is none."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from achse.ams import NetId
from achse.motion.remains import Remains
from achse.router.routes import Route
from achse.station import Station
from achse.station.config import parse
from achse.station.parameter_file import ParameterFile
from achse.station.state_file import StateFile


def test_a_document_comes_back(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.json")
    assert (file.read(), file.read_json()) == (None, None)
    file.write_json({"ä": [1, 2.5]})
    assert StateFile(file.path).read_json() == {"ä": [1, 2.5]}
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_the_old_text_stays_if_the_new_one_cannot_be_written(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    (tmp_path / "a.txt.new").mkdir()
    with pytest.raises(OSError, match=r"a\.txt\.new"):
        file.write("new")
    assert file.read() == "old"


def test_a_byte_order_mark_is_no_text(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.path.write_bytes(b"\xef\xbb\xbf{}")
    assert file.read_json() == {}


def test_what_may_never_end_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(OSError, match="not a regular file"):
            StateFile(path).read()


def test_a_file_makes_place_for_another(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    assert file.put_aside() == tmp_path / "a.txt.damaged"
    assert (file.read(), (tmp_path / "a.txt.damaged").read_text()) == (None, "old")


SYSTEM_CALLS = {"open", "write", "flush", "close", "fsync", "replace", "__exit__"}
"""What Python calls for one, by name."""


def killed_at(number: int, act: Callable[[], object]) -> bool:
    """Do `act` in a process that is killed before or after a system call; False if it is done."""
    child = os.fork()
    if child == 0:
        left = number

        def watch(_: FrameType, event: str, function: Any) -> None:
            nonlocal left
            if event in ("c_call", "c_return") and function.__name__ in SYSTEM_CALLS:
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.setprofile(watch)
        try:
            act()
        finally:
            sys.setprofile(None)
            os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


ROUTES = [Route(name=f"r{n}", net_id=NetId(f"5.1.1.{n}.1.1"), host="10.0.0.1") for n in range(3)]


def change_routes(folder: Path, step: int) -> Callable[[], object]:
    config = parse({"router": {"static_routes": "state"}}, "a.toml")
    table = Station(config, base=folder).router.routes
    return lambda: table.add(ROUTES[step])


def routes_found(folder: Path) -> object:
    config = parse({"router": {"static_routes": "state"}}, "a.toml")
    return len(Station(config, base=folder).router.routes)


AXIS = {"id": 1, "name": "X", "persistent_data_enable": 1}


def move_axis(folder: Path, step: int) -> Callable[[], object]:
    config = parse({"system": {"persistent_data": "state"}, "axis": [AXIS]}, "a.toml")
    station = Station(config, base=folder)
    assert station.nc is not None
    remains = {1: Remains([0.0], float(step + 1), 1)}
    station.nc.remains = lambda: remains  # type: ignore[method-assign]
    return station.save


def axis_found(folder: Path) -> object:
    document = StateFile(folder / "state").read_json()
    return int(document["nc"]["1"]["position"])


def store_parameter(folder: Path, step: int) -> Callable[[], object]:
    store = ParameterFile(folder / "state").of(1)
    return lambda: store.update({0x607200: step + 1})


def parameter_found(folder: Path) -> object:
    return ParameterFile(folder / "state").of(1)[0x607200]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize(
    ("change", "found"),
    [
        (change_routes, routes_found),
        (move_axis, axis_found),
        (store_parameter, parameter_found),
    ],
)
def test_killed_at_any_system_call_the_old_or_the_new_is_there(
    tmp_path: Path,
    change: Callable[[Path, int], Callable[[], object]],
    found: Callable[[Path], Any],
) -> None:
    """Every file that a station writes, by what writes and reads it."""
    change(tmp_path, 0)()
    assert found(tmp_path) == 1
    old = (tmp_path / "state").read_bytes()
    seen: list[Any] = []
    meaning: dict[bytes, Any] = {}  # the same bytes are read the same
    number = 0
    act = change(tmp_path, 1)  # done in children only: here it is not done yet
    while killed_at(number, act):
        left = (tmp_path / "state").read_bytes()
        if left not in meaning:
            meaning[left] = found(tmp_path)
        seen.append(meaning[left])
        (tmp_path / "state").write_bytes(old)
        number += 1
    assert set(seen) == {1, 2}
    assert seen == sorted(seen), "once it is there it stays"
    assert len(seen) > 8
    assert found(tmp_path) == 2


def test_a_text_is_on_the_disk_before_its_name_and_the_name_before_the_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the power takes: whatever no fsync has kept. Before, there was none at all."""
    done: list[tuple[str, str]] = []
    fsync, replace = os.fsync, os.replace

    def keep(number: int) -> None:
        name = os.path.basename(os.readlink(f"/proc/self/fd/{number}"))
        done.append(("fsync", name))
        fsync(number)

    def rename(old: Path, new: Path) -> None:
        done.append(("replace", new.name))
        replace(old, new)

    monkeypatch.setattr(os, "fsync", keep)
    monkeypatch.setattr(os, "replace", rename)
    StateFile(tmp_path / "a.txt").write("new")
    assert done == [("fsync", "a.txt.new"), ("replace", "a.txt"), ("fsync", tmp_path.name)]
