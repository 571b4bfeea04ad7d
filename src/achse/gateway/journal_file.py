"""File of the journal of handles, in the state folder of the user or of the service."""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

from achse.ams import NetId
from achse.router.forwarding.journal import HandleJournal, JournalError
from achse.transport.file_lock import lock_file

log = logging.getLogger("achse.gateway")


def state_folder() -> Path | None:
    """Return ACHSE_STATE_DIR, the folder that systemd made (StateDirectory), or the user's.

    None for a user without a home.
    """
    for name in ("ACHSE_STATE_DIR", "STATE_DIRECTORY"):
        chosen = os.environ.get(name, "").partition(":")[0]
        if chosen:
            return Path(chosen)
    base = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_STATE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".local" / "state") / "achse"
    except RuntimeError as failure:
        log.warning("no state folder: %s; give one: ACHSE_STATE_DIR", failure)
        return None


@contextmanager
def opened_journal(net_id: NetId, folder: Path | None) -> Iterator[HandleJournal]:
    """The journal of the router with this NetId; in memory alone without a folder.

    Where its file cannot be used, or another process holds it, a warning is logged and the journal
    is in memory alone: what this process leaves when it is killed stays at the targets.
    """
    if folder is None:
        yield HandleJournal()
        return
    path = folder / f"router-{net_id}.handles"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        file = FileIO(path, "r+", opener=_open_private)
    except OSError as failure:
        _warn(path, failure.strerror or str(failure))
        yield HandleJournal()
        return
    with file:
        yield _read(file, path)


def _open_private(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_CREAT, 0o600)


def _read(file: FileIO, path: Path) -> HandleJournal:
    if not lock_file(file):
        _warn(path, "another router has it")
        return HandleJournal()
    try:
        journal = HandleJournal(file)
    except OSError as failure:
        _warn(path, failure.strerror or str(failure))
    except JournalError as fault:
        _warn(path, str(fault))
    else:
        if journal:
            log.warning("%s: %d handles of before are to be released", path, len(journal))
        return journal
    return HandleJournal()


def _warn(path: Path, reason: str) -> None:
    log.warning(
        "%s: %s; handles stay at the targets if this router is killed (another folder:"
        " ACHSE_STATE_DIR)",
        *(path, reason),
    )
