"""Files of a slave by ADS, with a line on a terminal of how far they are."""

import asyncio
import struct
import sys
from collections.abc import Awaitable
from typing import TYPE_CHECKING

from achse.ams import AdsError
from achse.cli.failure import in_json

if TYPE_CHECKING:
    from achse.client.target import Target

_OPEN_READ, _OPEN_WRITE, _CLOSE, _READ, _WRITE, _PROGRESS = range(0xF401, 0xF407)
_PART = 0x4000
_LONGEST_S = 3600.0
_LOOK_S = 0.2
_PROGRESS_FIELDS = struct.Struct("<4I")


async def read_file(slave: "Target", name: str, password: int) -> bytes:
    """Return a whole file; raises AdsError."""
    slave = slave.within(_LONGEST_S)
    handle = await _opened(slave, _OPEN_READ, name, password)
    part = await _with_progress(slave, handle, slave.read_write_raw(_READ, handle, _PART, b""))
    data = b""
    while part:
        data += part
        part = await slave.read_write_raw(_READ, handle, _PART, b"")
    await slave.read_write_raw(_CLOSE, handle, 0, b"")
    return data


async def write_file(slave: "Target", name: str, password: int, data: bytes) -> None:
    """Write a whole file; raises AdsError."""
    slave = slave.within(_LONGEST_S)
    handle = await _opened(slave, _OPEN_WRITE, name, password)
    for at in range(0, len(data), _PART):
        await slave.read_write_raw(_WRITE, handle, 0, data[at : at + _PART])
    await _with_progress(slave, handle, slave.read_write_raw(_CLOSE, handle, 0, b""))


async def _opened(slave: "Target", group: int, name: str, password: int) -> int:
    answer = await slave.read_write_raw(group, password, 4, name.encode("latin-1", "replace"))
    return int.from_bytes(answer, "little")


async def _with_progress(slave: "Target", handle: int, request: Awaitable[bytes]) -> bytes:
    """Return the answer to a request that takes long."""
    task = asyncio.ensure_future(request)
    shows = sys.stderr.isatty() and not in_json()
    shown = ""
    while not (await asyncio.wait((task,), timeout=_LOOK_S))[0]:
        try:
            progress = await slave.read_raw(_PROGRESS, handle, 256)
        except AdsError:  # it has just ended
            continue
        line = progress_line(progress)
        if shows and line != shown:
            print(f"\r{line:60}", end="", file=sys.stderr, flush=True)
            shown = line
    if shown:
        print(file=sys.stderr)
    return task.result()


def progress_line(progress: bytes) -> str:
    """Return the progress line of a file from the data of the slave's port (0xF406)."""
    done, whole, busy, all_ = _PROGRESS_FIELDS.unpack_from(progress)
    words = progress[_PROGRESS_FIELDS.size :].partition(b"\0")[0].decode("cp1252")
    line = f"{done} of {whole} bytes" if whole else f"{done} bytes"
    if words or all_:
        line += f", {words or 'busy'}" + (f" {100 * busy // all_} %" if all_ else "")
    return line
