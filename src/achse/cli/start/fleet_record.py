"""Records of fleets that run: where their supervisor takes orders, and the key to it.

They are beside those of detached stations, locked as long as the supervisor lives.
"""

import contextlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from achse.cli.failure import fail
from achse.cli.start.detached import runtime_folder
from achse.transport.file_lock import lock_file

_TAKEN = "fleet-"


class FleetRecord(NamedTuple):
    """A fleet that runs."""

    name: str
    file: str
    """Its fleet.toml, absolute."""
    pid: int
    """Of the supervisor."""
    port: int
    key: str

    def order(self, order: str, **details: Any) -> Any:
        """Return the supervisor's answer to an order; if it refuses, end the command."""
        import asyncio

        from achse.fleet.orders import OrderError, give_order

        try:
            return asyncio.run(give_order(self.port, self.key, order, **details))
        except OrderError as fault:
            fail(str(fault))
        except OSError as failure:
            fail(f"the supervisor of {self.name}, process {self.pid}: {failure.strerror}")


def fleet_logs(name: str) -> Path:
    """Return the folder for the logs of a fleet."""
    return runtime_folder() / f"{_TAKEN}{name}-logs"


def _file(name: str) -> Path:
    return runtime_folder() / f"{_TAKEN}{name}.json"


@contextlib.contextmanager
def fleet_recorded(record: FleetRecord) -> Iterator[None]:
    """Meanwhile the record is there, and this process holds it; one fleet of a name runs."""
    file = _file(record.name)
    being_made = file.with_name(f"{file.stem}-{os.getpid()}.new")
    there = next((each for each in fleets() if each.name == record.name), None)
    if there is not None:
        fail(
            f"fleet {record.name} runs already, supervisor in process {there.pid};"
            f" `achse fleet down {record.name}` ends it",
            name="RUNS_ALREADY",
        )
    with open(os.open(being_made, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o600), "w") as opened:
        lock_file(opened)
        json.dump(record._asdict(), opened)
        opened.flush()
        _place(being_made, file, record.name)
        try:
            yield
        finally:
            file.unlink(missing_ok=True)
            _locked_files.append(os.dup(opened.fileno()))


_locked_files: list[int] = []
"""Files of records that are locked until this process has ended: `until_gone` waits for that."""


def _place(being_made: Path, file: Path, name: str) -> None:
    """Write the record; of two fleets that start at the same time one gets the name."""
    try:
        os.link(being_made, file)
    except FileExistsError:
        fail(f"fleet {name} is being started by another process", name="RUNS_ALREADY")
    except OSError:  # a file system without links
        being_made.replace(file)
    finally:
        being_made.unlink(missing_ok=True)


@contextlib.contextmanager
def until_gone(record: FleetRecord) -> Iterator[Callable[[], bool]]:
    """Gives a question: whether the supervisor of that record, its process too, has ended."""
    try:
        file = _file(record.name).open("r+", encoding="utf-8")
    except OSError:  # gone already
        yield lambda: True
        return
    with file:
        yield lambda: lock_file(file)


def fleets() -> list[FleetRecord]:
    """Return the running fleets, by name; remove records of others."""
    records = []
    for file in sorted(runtime_folder().glob(f"{_TAKEN}*.json")):
        try:
            with file.open("r+", encoding="utf-8") as record:
                if not lock_file(record):
                    records.append(FleetRecord(**json.load(record)))
                    continue
            file.unlink(missing_ok=True)
        except (OSError, ValueError, TypeError):  # it ends in this moment, or is not a record
            continue
    return records


def the_fleet(which: str | None) -> FleetRecord:
    """Return the fleet of that name or fleet.toml, or the only one; what is not there ends the
    command."""
    running = fleets()
    matches = [
        each
        for each in running
        if which is None or which == each.name or str(Path(which).resolve()) == each.file
    ]
    if len(matches) == 1:
        return matches[0]
    names = ", ".join(each.name for each in running) or "none"
    if not running:
        return fail("no fleet runs (`achse fleet up fleet.toml` starts one)", name="NOT_FOUND")
    if which is None:
        return fail(f"which fleet? There are: {names}", name="NOT_FOUND")
    return fail(f"fleet {which} does not run; there are: {names}", name="NOT_FOUND")
