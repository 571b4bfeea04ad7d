"""A recorded run: is the behaviour of this tree, byte by byte, that of another one?

Scripted clients on stations in virtual time: every frame that they send and get, with its station
time, and the state hash of the station now and then. All is drawn from one seed, so that the same
code gives the same lines.
Usage: python benchmarks/same_run.py --save FILE in one tree, --compare FILE in the other, with
equal --seconds and --turns.
"""

import argparse
import hashlib
import itertools
import json
import random
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.codes.station import ONLINE_CHANGE
from achse.devices.slave_service import OBJECTS, STATES, SlaveService
from achse.devices.station import FAULTS, STATISTICS
from achse.drive import Drive
from achse.ethercat import Segment, Slave
from achse.faults.drive_list import DriveFaults
from achse.router import Router
from achse.station import Station
from achse.station.configuration.station_file import parse

SERVICE = 26_000
BY_NAME, HANDLE, UPLOAD, SUM_READ = 0xF004, 0xF003, 0xF00B, 0xF080

STATION_FAULTS: tuple[dict[str, Any], ...] = (
    {"kind": "drop", "count": 2, "command": "read"},
    {"kind": "drop", "every": 3, "side": "request", "lasting": 0.2},
    {"kind": "delay", "by": 0.013, "count": 3, "at": 0.5},
    {"kind": "duplicate", "count": 1, "port": 851},
    {"kind": "reorder", "by": 0.02, "lasting": 0.3},
    {"kind": "truncate", "size": 3, "count": 2},
    {"kind": "wrong_invoke_id", "count": 1},
    {"kind": "error", "symbol": "MAIN.nCounter", "code": 0x705, "lasting": 0.4},
    {"kind": "error", "port": 851, "group": 0x4020, "code": 0x70A, "count": 2},
    {"kind": "error", "command": "read_state", "code": 0x745, "count": 1},
    {"kind": "router_error", "code": 7, "count": 1},
    {"kind": "drop", "command": "notification", "count": 4},
    {"kind": "slow_cycle", "factor": 3, "lasting": 0.55},
    {"kind": "slow_cycle", "lasting": 0.2, "at": 1.234567891},
    {"kind": "online_change", "at": 0.7031},
    {"kind": "download"},
    {"kind": "refuse_links", "lasting": 0.1},
    {"kind": "one_connection", "lasting": 0.1},
    {"kind": "drop_link", "client": "10.0.0.1.1.1"},
    {"kind": "config", "lasting": 1.0, "at": 2.0},
    {"kind": "restart"},
    {"kind": "melt"},
    {"kind": "drop", "code": 5},
    {"kind": "delay"},
    {"kind": "drop", "count": 0},
    {"kind": "drop", "count": True},
    {"kind": "drop", "at": "soon"},
    {"kind": "drop", "offset": 1},
    {"kind": "drop", "side": "left"},
    {"kind": "drop", "command": "dance"},
    {"kind": "drop", "client": "nobody"},
    {"kind": "drop", "port": 70_000},
    {"kind": "drop", "at": -1},
    {"kind": "drop", "colour": 1},
    {"kind": "restart", "port": 851},
    {"kind": "restart", "port": None, "every": 1, "side": "answer"},
    {"kind": "error", "code": 1, "symbol": "X.y"},
    {"kind": "error", "code": 1, "group": 1, "port": 99},
    {"kind": "download", "port": 501},
    {"kind": 5},
    {},
)
DRIVE_FAULTS: tuple[dict[str, Any], ...] = (
    {"kind": "alarm", "code": "AL.720", "drive": 1, "lasting": 0.05},
    {"kind": "alarm", "code": "0xFF10"},
    {"kind": "alarm", "code": "AL.1"},
    {"kind": "warning", "code": "AL.910", "at": 0.01},
    {"kind": "encoder_loss", "drive": 2, "lasting": 0.02},
    {"kind": "sto", "lasting": 0.1},
    {"kind": "safety", "drive": 2, "lasting": 0.03},
    {"kind": "overtravel", "side": "negative", "lasting": 0.02},
    {"kind": "overtravel", "side": "up"},
    {"kind": "input", "code": "HOME", "side": "off", "lasting": 0.1},
    {"kind": "input", "code": "I9"},
    {"kind": "main_power", "lasting": 0.04},
    {"kind": "load", "by": 123.4, "lasting": 0.02},
    {"kind": "load"},
    {"kind": "jam", "drive": 1, "lasting": 0.05},
    {"kind": "yaw_alarm", "lasting": 0.01},
    {"kind": "local_control", "lasting": 0.03},
    {"kind": "mailbox_delay", "by": 0.5, "lasting": 0.02},
    {"kind": "mailbox_delay", "by": -0.5},
    {"kind": "hang", "drive": 2, "lasting": 0.02},
    {"kind": "lost_frames", "count": 3},
    {"kind": "wrong_counter", "by": 2, "lasting": 0.01},
    {"kind": "link_break", "drive": 2, "lasting": 0.05},
    {"kind": "eeprom", "drive": 1, "lasting": 0.05},
    {"kind": "clock_drift", "by": 30, "lasting": 0.02},
    {"kind": "clock_jitter", "by": 1e-6, "lasting": 0.02},
    {"kind": "sto", "drive": 9},
    {"kind": "sto", "drive": 0},
    {"kind": "sto", "code": "AL.720"},
    {"kind": "sto", "symbol": "x"},
    {"kind": "lost_frames", "drive": 1},
    {"kind": "sto", "lasting": "50ms"},
)


class Talker:
    """A client whose frames are kept."""

    def __init__(self, router: Router, source: AmsAddress, lines: list[str]) -> None:
        self.router = router
        self.address = source
        self.lines = lines
        self.answers: list[Frame] = []
        self._invoke_ids = itertools.count(1)
        router.register(source.port, self)

    def deliver(self, frame: Frame) -> bool:
        self.lines.append("< " + frame.encode_tcp().hex())
        self.answers.append(frame)
        return True

    def ask(self, port: int, command: Command, data: bytes = b"") -> bytes:
        """Send a request; the data of the last frame that came, if any did."""
        target = AmsAddress.of(self.router.net_id, port)
        frame = Frame(target, self.address, command, invoke_id=next(self._invoke_ids), data=data)
        self.lines.append("> " + frame.encode_tcp().hex())
        self.answers.clear()
        self.router.deliver(frame)
        return self.answers[-1].data if self.answers else b""

    def read(self, port: int, group: int, offset: int, length: int) -> bytes:
        return self.ask(port, Command.READ, struct.pack("<III", group, offset, length))

    def write(self, port: int, group: int, offset: int, data: bytes = b"") -> bytes:
        place = struct.pack("<III", group, offset, len(data))
        return self.ask(port, Command.WRITE, place + data)

    def exchange(self, port: int, group: int, offset: int, length: int, data: bytes) -> bytes:
        place = struct.pack("<IIII", group, offset, length, len(data))
        return self.ask(port, Command.READ_WRITE, place + data)

    def subscribe(self, port: int, place: tuple[int, int, int], mode: int, cycle_ms: float) -> None:
        body = ADD_NOTIFICATION_BODY.pack(*place, mode, 0, round(cycle_ms * 10_000))
        self.ask(port, Command.ADD_NOTIFICATION, body)

    def service(self, service: int, at: int = 0, /, **fields: Any) -> None:
        self.exchange(SERVICE, service, at, 1 << 16, json.dumps(fields).encode())


def stations() -> Iterator[tuple[str, Station]]:
    """The demo; one whose cycles have little in common; one without a PLC; one without anything."""
    yield "demo", Station.demo()
    task = {"cycle": "7ms", "programs": ["achse.station.demo:MAIN"]}
    slow = {"name": "Slow", "cycle": "17.5ms", "priority": 21, "programs": []}
    axes = [{"id": number, "name": f"A{number}"} for number in (1, 2, 3)]
    for code in ("plain", "machine"):
        document = {
            "nc": {"cycle": "2ms", "code": code},
            "axis": axes,
            "plc": [{"task": [task, slow], "globals": ["achse.station.demo:GVL"]}],
            "fault": [{"kind": "delay", "by": "5ms", "at": "100ms", "lasting": "300ms"}],
        }
        yield f"odd cycles, {code}", Station(parse(document, "recorded"))
    yield "axes only", Station(parse({"axis": axes, "nc": {"cycle": "1500us"}}, "recorded"))
    yield "nothing", Station(parse({}, "recorded"))


def act(draw: random.Random, talker: Talker) -> None:
    """One thing that a client does."""
    axis = draw.randint(1, 3)
    match draw.randrange(12):
        case 0:
            talker.write(501, 0x4300 + axis, 0x01, struct.pack("<I", draw.choice((0, 7))))
        case 1:
            override = struct.pack("<I", draw.choice((0, 500_000, 1_000_000)))
            talker.write(501, 0x4300 + axis, 0x21, override)
        case 2 | 3:
            move = struct.pack("<I4xdd", 1, draw.uniform(-500, 500), draw.uniform(1, 300))
            talker.write(501, 0x4200 + axis, 0x20, move)
        case 4:
            talker.write(501, 0x4200 + axis, draw.choice((0x01, 0x02)))
        case 5:
            talker.exchange(851, BY_NAME, 0, 4, b"MAIN.nCounter\0")
        case 6:
            handle = talker.exchange(851, HANDLE, 0, 4, b"GVL.nInt\0")[8:]
            if len(handle) == 4:
                talker.read(851, 0xF005, int.from_bytes(handle, "little"), 2)
        case 7:
            place = draw.choice(((0x4101, 0x0A, 8), (0x4102, 0x0D, 8), (0x4103, 0x0E, 8)))
            cycle = draw.choice((0, 1, 2, 3.5, 10, 33))
            talker.subscribe(501, place, draw.choice((3, 4)), cycle)
        case 8:
            talker.subscribe(851, (0x4020, 0, 4), draw.choice((3, 4)), draw.choice((0, 7, 20)))
        case 9:
            parts = b"".join(struct.pack("<III", 0x4101, offset, 8) for offset in (0x0A, 0x0D))
            talker.exchange(501, SUM_READ, 2, 24, parts)
        case 10:
            port = draw.choice((1, 100, 110, 500, 501, 851, 10_000, SERVICE))
            talker.ask(port, draw.choice((Command.READ_STATE, Command.READ_DEVICE_INFO)))
        case 11:
            talker.read(501, 0x4100 + axis, 0, 64)


def talk(name: str, station: Station, lines: list[str], turns: int) -> None:
    """A session: commands, subscriptions, faults, restarts, and time in between."""
    draw = random.Random(name)
    talker = Talker(station.router, AmsAddress.of(station.router.net_id, 40_000), lines)
    talker.read(851, UPLOAD, 0, 1 << 20)
    faults = list(STATION_FAULTS)
    draw.shuffle(faults)
    for turn in range(turns):
        act(draw, talker)
        if turn % 8 == 7 and faults:
            talker.service(FAULTS, **faults.pop())
            talker.read(SERVICE, FAULTS, 0, 1 << 16)
        if turn % 50 == 49:
            talker.write(SERVICE, FAULTS, 0, bytes(4))
            talker.service(ONLINE_CHANGE, draw.choice((0, 851, 7)))
        if turn % 90 == 89:
            draw.choice((station.restart, station.configure))()
        if turn % 90 == 20:
            station.restart()
        for _ in range(draw.randrange(3)):
            station.step()
        station.advance(draw.choice((0.0, 0.0007, 0.003, 0.02, 0.11, 0.5, 1.3)))
        statistics = json.loads(talker.read(SERVICE, STATISTICS, 0, 1 << 16)[8:])
        lines.append(f"{statistics['time']} {station.time_ns} {station.state} {station.digest()}")
    station.shut_down(0.02)
    station.advance(0.1)
    lines.append(f"{station.ended} {station.time_ns} {station.digest()}")


def talk_to_drives(lines: list[str]) -> None:
    """Every fault of drives, states and objects."""
    draw = random.Random("drives")
    segment = Segment([Slave(Drive()), Slave(Drive())])
    router = Router(NetId("127.0.0.1.1.1"))
    SlaveService(segment, DriveFaults(segment)).attach(router, SERVICE)
    talker = Talker(router, AmsAddress("127.0.0.1.1.1:40000"), lines)
    now = 0
    faults = [*DRIVE_FAULTS, *draw.sample(DRIVE_FAULTS, len(DRIVE_FAULTS))]
    for number, fault in enumerate(faults):
        talker.service(FAULTS, **fault)
        for _ in range(draw.randrange(4)):
            now += draw.choice((1_000_000, 5_000_000, 20_000_000))
            segment.advance(now)
            talker.read(SERVICE, FAULTS, 0, 1 << 16)
        talker.read(SERVICE, STATES, 0, 1 << 16)
        talker.service(OBJECTS, index=draw.choice((0x603F, 0x6041, 0x6064, 0x3110)), drive=1)
        if number % 10 == 9:
            talker.write(SERVICE, FAULTS, 0, struct.pack("<I", draw.choice((0, number, 999))))


def demo(seconds: float) -> str:
    """The state after `achse run --speed max --for SECONDS`."""
    station = Station.demo()
    station.advance(seconds)
    return station.digest()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--compare", type=Path)
    parser.add_argument("--seconds", type=float, default=3600.0, help="of the demo station")
    parser.add_argument("--turns", type=int, default=400, help="of the talk with each station")
    arguments = parser.parse_args()
    lines = [f"# {arguments.seconds:g} s of the demo", demo(arguments.seconds)]
    for name, station in stations():
        lines.append(f"# {name}")
        talk(name, station, lines, arguments.turns)
    lines.append("# drives")
    talk_to_drives(lines)
    text = "\n".join(lines) + "\n"
    digest = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
    print(f"{sum(line[0] in '<>' for line in lines)} frames, {len(lines)} lines, hash {digest}")
    if arguments.save:
        arguments.save.write_text(text)
    if arguments.compare:
        before = arguments.compare.read_text().splitlines()
        for number, (old, new) in enumerate(itertools.zip_longest(before, lines), 1):
            if old != new:
                sys.exit(f"line {number} differs:\n{old}\n{new}")
        print("equal, byte by byte")


if __name__ == "__main__":
    main()
