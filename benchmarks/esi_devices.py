"""Bring each device of ESI files to Op, with our master in memory: `esi_devices.py FOLDER…`.

A line for each device that does not get there, with the cause, and a table of the files. `--json`
prints what was seen. The files of makers are not here: put those that you have into a folder.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from achse.codes import AlState
from achse.ethercat import Datagram, EthercatFrame, Segment
from achse.ethercat.master import BusConfiguration, BusError, Master, Ring, SlaveConfiguration
from achse.ethercat.master.esi_reader import EsiDevice, EsiError, from_esi, read_esi
from achse.ethercat.master.scanning import scan_bus
from achse.ethercat.master.steps import Pause, Round, Steps, Trip
from achse.ethercat.virtual import make_slave

T = TypeVar("T")

CYCLE_NS, FRAME_NS = 2_000_000, 50_000
MOST_CYCLES = 5_000


def survey(file: Path) -> list[dict[str, str]]:
    """A row for each device of a file; a file that is refused has one row."""
    try:
        devices = read_esi(file.read_bytes())
    except EsiError as fault:
        return [{"file": file.name, "device": "", "fault": f"not read: {fault}"}]
    return [
        {
            "file": file.name,
            "device": f"{each.type_name} {each.revision_number:08X}",
            "fault": by_file(each) or by_scan(each),
        }
        for each in devices
    ]


def by_file(device: EsiDevice) -> str:
    """Why a slave does not get to Op that the master knows from the same file."""
    try:
        slave = make_slave(device)
        return operate(Segment([slave]), from_esi(slave.device.esi, cycle_ns=CYCLE_NS))
    except EsiError as fault:
        return f"from the file: {fault}"


def by_scan(device: EsiDevice) -> str:
    """Why a slave does not get to Op that the master scans."""
    segment = Segment([make_slave(device)])
    try:
        (slave,) = do_steps(segment, scan_bus())
    except BusError as fault:
        return f"scan: {fault}"
    if slave.trouble:
        return f"scan: {slave.trouble}"
    return operate(segment, slave.configuration)


def do_steps(segment: Segment, steps: Steps[T]) -> T:
    """Do the steps of a request on a segment; raises `BusError`."""
    request: Trip | Pause | None = None
    now_ns = segment.time.now_ns
    back: Round | None = None
    while True:
        try:
            request = steps.send(back) if back is not None else next(steps)
        except StopIteration as end:
            value: T = end.value
            return value
        now_ns += FRAME_NS if isinstance(request, Trip) else request.ns
        segment.advance(now_ns)
        datagrams: Sequence[Datagram] = ()
        if isinstance(request, Trip):
            reply = segment.process(EthercatFrame(request.datagrams).encode())
            assert reply is not None
            datagrams = EthercatFrame.decode(reply).datagrams
        back = Round(datagrams, now_ns)


def operate(segment: Segment, slave: SlaveConfiguration) -> str:
    """Why a slave does not get to Op, empty if it does."""
    master = Master(BusConfiguration((slave,), cycle_ns=CYCLE_NS))
    master.request(AlState.OP)
    ring = Ring(master, segment)
    start = segment.time.now_ns
    for cycle in range(1, MOST_CYCLES):
        ring.exchange(start + cycle * CYCLE_NS)
        if master.operational:
            return ""
        if master.slaves[0].error:
            break
    return master.slaves[0].last_trouble or f"state {master.slaves[0].state}"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("places", type=Path, nargs="+")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = []
    for place in options.places:
        files = sorted(place.rglob("*.xml")) if place.is_dir() else [place]
        rows += [row for file in files for row in survey(file)]
    if options.json:
        json.dump(rows, sys.stdout, indent=1)
        return
    for row in rows:
        if row["fault"]:
            print(f"{row['file']}: {row['device']}: {row['fault']}")
    reached = Counter(bool(row["fault"]) for row in rows)
    print(
        f"{len({row['file'] for row in rows})} files, {len(rows)} devices, {reached[False]} in Op"
    )


if __name__ == "__main__":
    main()
