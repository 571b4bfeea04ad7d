"""Kills a process before and after each system call with which a station replaces a file.

    python -m tests.station.persistence.killed_writes FOLDER

Prints what was in each file after each of those, and at the end, as JSON. A program of its own
forks: a process with threads may do so while one of them holds a lock.
"""

import io
import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

from achse.ams import NetId
from achse.motion.retained import RetainedState
from achse.router.routes import Route
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.station.persistence.state_file import StateFile
from achse.station.slaves.parameter_file import ParameterFile

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
                if isinstance(function.__self__, io.StringIO | io.BytesIO):
                    return  # in memory
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
    remains = {1: RetainedState([0.0], float(step + 1), 1)}
    station.nc.retained_state = lambda: remains  # type: ignore[method-assign]
    return station.save


def axis_found(folder: Path) -> object:
    document = StateFile(folder / "state").read_json()
    return int(document["nc"]["1"]["position"])


def store_parameter(folder: Path, step: int) -> Callable[[], object]:
    store = ParameterFile(folder / "state").of(1)
    return lambda: store.update({0x607200: step + 1})


def parameter_found(folder: Path) -> object:
    return ParameterFile(folder / "state").of(1)[0x607200]


WRITERS: dict[str, tuple[Callable[[Path, int], Callable[[], object]], Callable[[Path], Any]]] = {
    "routes": (change_routes, routes_found),
    "axis": (move_axis, axis_found),
    "parameter": (store_parameter, parameter_found),
}
"""What writes a file in step n, and what reads it: n + 1."""


def found_after_kills(name: str, folder: Path) -> list[Any]:
    """What is in the file after a kill at each system call, and when none was left to kill at."""
    change, read = WRITERS[name]
    change(folder, 0)()
    old = (folder / "state").read_bytes()
    seen: list[Any] = [read(folder)]
    meaning: dict[bytes, Any] = {}  # the same bytes are read the same
    number = 0
    act = change(folder, 1)  # done in children only: here it is not done yet
    while killed_at(number, act):
        left = (folder / "state").read_bytes()
        if left not in meaning:
            meaning[left] = read(folder)
        seen.append(meaning[left])
        (folder / "state").write_bytes(old)
        number += 1
    return [*seen, read(folder)]


if __name__ == "__main__":
    contents = {}
    for name in WRITERS:
        folder = Path(sys.argv[1]) / name
        folder.mkdir()
        contents[name] = found_after_kills(name, folder)
    print(json.dumps(contents))
