"""Records sessions of clients by others, for test_sessions.py to replay.

    python -m tests.replay.record pyads|ads-client|pysoem FILE

Time stands still while a client talks: the session is the same whenever it is replayed. A line is
what the client sent (`>`), what our side answered (`<`), or seconds of station time (`!`). pysoem
needs a network namespace and root.
"""

import contextlib
import fcntl
import json
import os
import queue
import select
import socket
import struct
import subprocess
import sys
import termios
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from achse.ams import Command, Connection, Frame
from achse.station import Station
from achse.testing import LiveStation, free_host
from achse.transport.ethernet import EthernetLink
from tests.replay.test_sessions import NET_ID, cable, length_of

NPM = Path(__file__).parents[1] / "interop" / "npm"


class Relay:
    """Is between a client and a station, and writes down what passes."""

    def __init__(self, station: LiveStation) -> None:
        self.station = station
        self.lines: list[str] = []
        self.host = free_host()
        self._unanswered = 0
        self._sockets: list[socket.socket] = []
        self._passed = threading.Condition()
        self._listener = socket.create_server((self.host, 48898))
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                server = socket.create_connection((self.station.host, self.station.tcp_port))
                self._sockets += client, server
                for source, sink, sign in ((client, server, ">"), (server, client, "<")):
                    threading.Thread(
                        target=self._pass, args=(source, sink, sign), daemon=True
                    ).start()

    def _pass(self, source: socket.socket, sink: socket.socket, sign: str) -> None:
        with contextlib.suppress(OSError):
            buffer = b""
            while select.select([source], [], []):
                with self._passed:  # read and passed on in one: see `_is_quiet`
                    data = source.recv(65_536)
                    if not data:
                        break
                    buffer += data
                    while len(buffer) >= 6 and len(buffer) >= (size := 6 + length_of(buffer)):
                        self._note(buffer[:size], sign)
                        sink.sendall(buffer[:size])
                        buffer = buffer[size:]
                    self._passed.notify_all()
            sink.shutdown(socket.SHUT_WR)

    def _note(self, packet: bytes, sign: str) -> None:
        """Write a packet down, and whether its answer is to come."""
        self.lines.append(f"{sign} {packet.hex()}")
        (message,) = Connection().receive(packet)
        if sign == ">":
            self._unanswered += 1
        elif not (isinstance(message, Frame) and message.command == Command.NOTIFICATION):
            self._unanswered -= 1

    def _is_quiet(self) -> bool:
        """True if each request has its answer and nothing is on its way through the relay."""
        return not self._unanswered and not any(map(_waiting_bytes, self._sockets))

    def wait(self) -> None:
        """Wait until nothing passes any more."""
        with self._passed:
            self._passed.wait_for(self._is_quiet)

    def advance(self, seconds: float) -> None:
        """Let station time pass between two exchanges."""
        self.wait()
        self.lines.append(f"! {seconds}")
        self.station.advance(seconds)
        self.wait()


def _waiting_bytes(line: socket.socket) -> int:
    """Return how much has come on a line and is not read yet."""
    if line.fileno() < 0:
        return 0
    return int.from_bytes(fcntl.ioctl(line, termios.FIONREAD, bytes(4)), sys.byteorder)


@contextlib.contextmanager
def relayed() -> Iterator[Relay]:
    with LiveStation(lambda: Station.demo(net_id=NET_ID), time=0.0) as station:
        relay = Relay(station)
        yield relay
        relay.wait()


def record_pyads() -> list[str]:
    """Variables by name, handle and sum, a structure, an axis, an error, a notification."""
    import pyads

    samples = queue.SimpleQueue[None]()
    with relayed() as relay:
        pyads.open_port()
        pyads.set_local_address("192.0.2.7.1.1")
        pyads.add_route(NET_ID, relay.host)
        plc = pyads.Connection(NET_ID, 851, relay.host)
        plc.open()
        plc.read_state()
        plc.read_device_info()
        plc.write_by_name("GVL.nInt", 1234, pyads.PLCTYPE_INT)
        plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT)
        plc.read_by_name("GVL.sString", pyads.PLCTYPE_STRING)
        handle = plc.get_handle("GVL.fLreal")
        plc.write_by_name("", -0.5, pyads.PLCTYPE_LREAL, handle=handle)
        plc.read_by_name("", pyads.PLCTYPE_LREAL, handle=handle)
        plc.release_handle(handle)
        plc.read_list_by_name(["GVL.nInt", "GVL.fReal", "GVL.bBool"])
        plc.write_list_by_name({"GVL.nDint": 5, "GVL.nUint": 6})
        with contextlib.suppress(pyads.ADSError):
            plc.read_by_name("GVL.nothing", pyads.PLCTYPE_INT)
        handles = plc.add_device_notification(
            "MAIN.nCounter", pyads.NotificationAttrib(4), lambda *_: samples.put(None)
        )
        relay.advance(0.05)
        for _ in range(6):  # one at once, and one in each cycle of 10 ms
            samples.get()
        plc.del_device_notification(*handles)
        nc = pyads.Connection(NET_ID, 501, relay.host)
        nc.open()
        nc.write(0x4301, 0x01, 7, pyads.PLCTYPE_UDINT)
        nc.write(0x4301, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)
        relay.advance(0.1)
        start = struct.pack("<I4xdd", 1, 10.0, 50.0)
        nc.write(0x4201, 0x20, list(start), pyads.PLCTYPE_BYTE * len(start))
        relay.advance(1.0)
        nc.read(0x4101, 0x0A, pyads.PLCTYPE_LREAL)
        nc.read(0x4301, 0x81, pyads.PLCTYPE_UDINT)
        nc.close()
        plc.close()
        relay.wait()
        return relay.lines


ADS_CLIENT = """
import { Client } from "ads-client";
const client = new Client({ hideConsoleWarnings: true, ...JSON.parse(process.argv[2]) });
await client.connect();
await client.readDeviceInfo();
await client.readPlcRuntimeState();
await client.writeValue("GVL.nDint", -123456);
await client.readValue("GVL.nDint");
await client.readValue("GVL.sString");
await client.writeValue("GVL.stPoint", { fX: 1.5, fY: -2.5, sName: "corner", bValid: true });
await client.readValue("GVL.stPoint");
await client.writeValue("GVL.eColour", "BLUE");
await client.readValue("GVL.eColour").catch(() => 0);
await client.readValue("GVL.nothing").catch(() => 0);
await client.disconnect();
process.exit(0);
"""


def record_ads_client() -> list[str]:
    """Directly to the station, as from another host: connection, values, a structure, an enum."""
    with relayed() as relay:
        settings = {
            "targetAmsNetId": NET_ID,
            "targetAdsPort": 851,
            "routerAddress": relay.host,
            "routerTcpPort": 48898,
            "localAmsNetId": "192.0.2.7.1.1",
            "localAdsPort": 32_750,
            "autoReconnect": False,
            "connectionCheckInterval": 3_600_000,
        }
        script = NPM / "session.tmp.mjs"
        script.write_text(ADS_CLIENT, encoding="utf-8")
        try:
            subprocess.run(["node", str(script), json.dumps(settings)], check=True)
        finally:
            script.unlink()
        return relay.lines


PYSOEM = """
import sys, struct, pysoem
master = pysoem.Master()
master.open(sys.argv[1])
assert master.config_init() == 2
first, second = master.slaves
first.sdo_read(0x1008, 0)
first.sdo_write(0x2000, 0, bytes(range(40)))
try:
    first.sdo_read(0x5000, 0)
except pysoem.SdoError:
    pass
second.sdo_read(0x1018, 1)
second.sdo_write(0x6083, 0, struct.pack("<I", 5000))
second.sdo_read(0x6083, 0)
master.config_map()
for n in range(5):
    master.send_processdata(); master.receive_processdata(500_000)
master.state = pysoem.OP_STATE
master.write_state()
for n in range(20):
    second.output = struct.pack("<HbHiHI", 6 if n < 10 else 7, 8, 3000, 0, 0, 0)
    first.output = bytes([n] * 4)
    master.send_processdata(); master.receive_processdata(500_000)
master.read_state()
master.state = pysoem.INIT_STATE
master.write_state()
master.read_state()
master.close()
"""


def record_pysoem() -> list[str]:
    """Scan, mailbox, process data, states."""
    if "ACHSE_INSIDE" not in os.environ:
        command = ["unshare", "--net", sys.executable, "-m", __spec__.name, "pysoem", sys.argv[2]]
        subprocess.run(command, env=os.environ | {"ACHSE_INSIDE": "1"}, check=True)
        sys.exit(0)
    for line in (
        "ip link add cable0 type veth peer name cable1",
        "ip link set cable0 up",
        "ip link set cable1 up",
    ):
        subprocess.run(line.split(), check=True)
    segment, lines = cable(), list[str]()
    link = EthernetLink("cable1")

    def answer(packet: bytes) -> bytes | None:
        reply: bytes | None = segment.process(packet)
        lines.append(f"> {bytes(packet).hex()}")
        lines.append(f"< {bytes(reply).hex()}" if reply is not None else "<")
        return reply

    with subprocess.Popen([sys.executable, "-c", PYSOEM, "cable0"]) as master:
        while master.poll() is None:
            link.exchange(answer, 0.005)
    assert master.returncode == 0
    return lines


RECORDERS: dict[str, Callable[[], Any]] = {
    "pyads": record_pyads,
    "ads-client": record_ads_client,
    "pysoem": record_pysoem,
}


if __name__ == "__main__":
    lines = RECORDERS[sys.argv[1]]()
    Path(sys.argv[2]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{len(lines)} lines")
