"""Recorded sessions of clients by others, replayed: every answer is what it was, byte by byte.

`python -m tests.replay.record` makes the recordings; what is meant to change is recorded again.
"""

import asyncio
from collections import deque
from pathlib import Path

import pytest

from achse.ams import Command, Connection, Frame
from achse.drive import IDENTITIES, Drive
from achse.ethercat import EthercatFrame as EthercatFrame
from achse.ethercat import Loopback, Segment, Slave
from achse.station import Station

SESSIONS = Path(__file__).parents[1] / "data" / "sessions"
NET_ID = "192.0.2.1.1.1"
CYCLE_NS = 1_000_000


def lines_of(name: str) -> list[tuple[str, str]]:
    """Sign and rest of each line: `>` was sent, `<` was answered, `!` seconds passed."""
    text = (SESSIONS / f"{name}.txt").read_text(encoding="utf-8")
    return [(line[0], line[2:]) for line in text.splitlines() if not line.startswith("#")]


@pytest.mark.parametrize("name", ["pyads", "ads-client"])
def test_each_packet_is_decoded_and_encoded_again(name: str) -> None:
    for sign, rest in lines_of(name):
        if sign != "!":
            (message,) = Connection().receive(bytes.fromhex(rest))
            assert message.encode_tcp().hex() == rest


class Incoming:
    """Answers and samples, each in their order; which of the two comes first may differ."""

    def __init__(self, reader: asyncio.StreamReader) -> None:
        self._reader = reader
        self._buffered: dict[bool, deque[str]] = {False: deque(), True: deque()}

    @staticmethod
    def is_sample(packet: str) -> bool:
        (message,) = Connection().receive(bytes.fromhex(packet))
        return isinstance(message, Frame) and message.command == Command.NOTIFICATION

    async def like(self, expected: str) -> str:
        """The next packet of the same sort as `expected`."""
        wanted = self.is_sample(expected)
        while not self._buffered[wanted]:
            head = await self._reader.readexactly(6)
            packet = (head + await self._reader.readexactly(length_of(head))).hex()
            self._buffered[self.is_sample(packet)].append(packet)
        return self._buffered[wanted].popleft()


def length_of(head: bytes) -> int:
    return int.from_bytes(head[2:6], "little")


@pytest.mark.parametrize("name", ["pyads", "ads-client"])
async def test_the_station_answers_as_recorded(name: str) -> None:
    station = Station.demo(net_id=NET_ID)
    async with station.running("127.0.0.1", 0, speed=0) as running:
        reader, writer = await asyncio.open_connection("127.0.0.1", running.tcp_port)
        incoming = Incoming(reader)
        for number, (sign, rest) in enumerate(lines_of(name), 1):
            if sign == ">":
                writer.write(bytes.fromhex(rest))
            elif sign == "<":
                assert await incoming.like(rest) == rest, f"{name}, line {number}"
            else:
                station.advance(float(rest))
        writer.close()


def cable() -> Segment:
    """What pysoem met: a loopback slave and a drive; frames with process data are the clock."""
    drive = Drive(identity=IDENTITIES["manual"])
    return Segment([Slave(Loopback(4, serial_number=1)), Slave(drive)], cycle_ns=CYCLE_NS)


def test_the_slaves_answer_as_recorded() -> None:
    segment, reply = cable(), ""
    for number, (sign, rest) in enumerate(lines_of("pysoem"), 1):
        if sign == ">":
            answer = segment.process(bytes.fromhex(rest))
            reply = "" if answer is None else bytes(answer).hex()
        else:
            assert reply == rest, f"pysoem, line {number}"


def test_each_ethercat_frame_is_decoded_and_encoded_again() -> None:
    for _, rest in lines_of("pysoem"):
        packet = bytes.fromhex(rest)
        again = EthercatFrame.decode(packet).encode()
        assert again[14:] == packet[14 : len(again)]
