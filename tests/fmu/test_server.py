"""The process of a unit, at the other end of a channel."""

import os
import socket
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from achse.fmu.model import UnitFile
from achse.fmu.protocol import VERSION, Reply, Request, UnitMessage, receive
from achse.fmu.server import main
from achse.fmu.variables import VariableChoice, chosen_variables
from achse.station import Station


def started(channel: socket.socket) -> Callable[[], int]:
    """Start the server as a shim does; return what waits for its exit code."""
    process = subprocess.Popen(
        [sys.executable, "-m", "achse.fmu"], stdin=channel.fileno(), stdout=subprocess.DEVNULL
    )
    return lambda: process.wait(timeout=600)


def forked(channel: socket.socket) -> Callable[[], int]:
    """Run the server in a fork of this process, which has imported it."""
    process = os.fork()
    if process == 0:
        os.dup2(channel.fileno(), 0)
        os.closerange(3, 64_000)
        try:
            main()
            os._exit(0)
        finally:
            os._exit(1)
    return lambda: os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


class Peer:
    """What a shim does, in Python."""

    def __init__(
        self, resources: Path, start: Callable[[socket.socket], Callable[[], int]]
    ) -> None:
        ours, theirs = socket.socketpair()
        self.channel = ours
        self.exit_code = start(theirs)
        theirs.close()
        self.resources = resources
        self.lines: list[bytes] = []

    def call(
        self, kind: int, content: bytes = b"", channel: socket.socket | None = None
    ) -> UnitMessage | None:
        """Return the reply, or None if the channel ended."""
        channel = channel or self.channel
        channel.sendall(struct.pack("<II", kind, len(content)) + content)
        while (message := receive(channel)) is not None and message.kind == Reply.LOG:
            self.lines.append(message.content)
        return message

    def open(self, token: bytes = b"{t}", version: int = VERSION) -> UnitMessage | None:
        names = os.fsencode(self.resources) + b"\0" + token + b"\0"
        return self.call(Request.OPEN, struct.pack("<I", version) + names)

    def call_for_channel(
        self, kind: int, content: bytes, channel: socket.socket
    ) -> tuple[bytes, socket.socket]:
        """Return content and channel of a reply."""
        channel.sendall(struct.pack("<II", kind, len(content)) + content)
        head, descriptors, *_ = socket.recv_fds(channel, 8, 1)
        kind, size = struct.unpack("<II", head)
        assert kind == Reply.DONE
        content = channel.recv(size, socket.MSG_WAITALL) if size else b""
        return content, socket.socket(fileno=descriptors[0])


@pytest.fixture
def resources(station_file: Path) -> Path:
    """The folder of a unit."""
    variables = chosen_variables(Station.load(station_file), VariableChoice(locals=["MAIN.nCount"]))
    unit = UnitFile("{t}", station_file.name, variables)
    (station_file.parent / "unit.json").write_text(unit.text(), encoding="utf-8")
    return station_file.parent


@pytest.fixture
def peer(resources: Path) -> Iterator[Peer]:
    peer = Peer(resources, forked)
    yield peer
    peer.channel.close()
    assert peer.exit_code() == 0


def number(value: int) -> bytes:
    return struct.pack("<Q", value)


def test_steps_show_the_image(peer: Peer) -> None:
    opened = peer.open()
    assert opened is not None
    assert opened.kind == Reply.DONE
    rows, inputs, size = struct.unpack_from("<3I", opened.content)
    assert len(opened.content) == 12 + 16 * rows + size
    assert 0 < inputs < size
    stepped = peer.call(Request.STEP, number(100_000_000))
    assert stepped is not None
    assert stepped.kind == Reply.DONE
    assert struct.pack("<I", 10) in stepped.content
    digest = peer.call(Request.REFRESH, number(rows - 1))
    station = Station.load(peer.resources / "station.toml")
    station.advance(0.1)
    assert digest is not None
    assert station.digest().encode() in digest.content


def test_saved_state_is_restored_any_number_of_times(peer: Peer) -> None:
    peer.open()
    peer.call(Request.STEP, number(50_000_000))
    _, state = peer.call_for_channel(Request.SAVE, struct.pack("<d", 0.05), peer.channel)
    images = set()
    for _ in range(3):
        content, channel = peer.call_for_channel(Request.RESTORE, b"", state)
        assert struct.unpack_from("<d", content) == (0.05,)
        stepped = peer.call(Request.STEP, number(90_000_000), channel)
        assert stepped is not None
        images.add(stepped.content)
        channel.close()
    assert len(images) == 1
    packed = peer.call(Request.PACK, b"", state)
    assert packed is not None
    _, replayed = peer.call_for_channel(Request.UNPACK, packed.content, peer.channel)
    refused = peer.call(Request.STEP, number(1), state)
    assert refused is not None
    assert refused.kind == Reply.FAILED
    again = peer.call(Request.PACK, b"", replayed)
    assert again == packed
    state.close()
    replayed.close()


def test_refused_requests_leave_the_server_ready(peer: Peer) -> None:
    for kind, content, complaint in (
        (Request.STEP, number(1), b"expected the request to open first"),
        (Request.RESTORE, b"", b"unknown here"),
        (77, b"", b"unknown here"),
        (Request.OPEN, b"", b"requires a buffer"),
    ):
        refused = peer.call(kind, content)
        assert refused is not None
        assert refused.kind == Reply.FAILED
        assert complaint in refused.content
    for token, version, complaint in (
        (b"{other}", VERSION, b"expected {t}, got b'{other}'"),
        (b"{t}", 99, b"expected 1; export"),
    ):
        refused = peer.open(token, version)
        assert refused is not None
        assert refused.kind == Reply.FAILED
        assert complaint in refused.content
    opened = peer.open()
    assert opened is not None
    assert opened.kind == Reply.DONE


def test_damaged_state_is_refused(peer: Peer) -> None:
    peer.open()
    refused = peer.call(Request.UNPACK, b"rubbish")
    assert refused is not None
    assert refused.kind == Reply.FAILED
    assert b"expected bytes of a serialised state" in refused.content


def test_exception_of_the_plc_is_a_line_of_the_log(peer: Peer) -> None:
    opened = peer.open()
    assert opened is not None
    rows, inputs, _ = struct.unpack_from("<3I", opened.content)
    image = bytearray(opened.content[12 + 16 * rows :][:inputs])
    unit = UnitFile.read(peer.resources)
    names = [each.name for each in unit.variables]
    row = opened.content[12 + 16 * names.index("MAIN.nSpeed") :]
    (offset,) = struct.unpack_from("<I", row, 8)
    struct.pack_into("<h", image, offset, 10)
    stepped = peer.call(Request.STEP, number(100_000_000) + image)
    assert stepped is not None
    assert stepped.kind == Reply.DONE
    assert any(b"ivision" in line or b"DIVIDE" in line for line in peer.lines), peer.lines


def test_process_ends_with_its_shim(resources: Path) -> None:
    peer = Peer(resources, started)
    peer.open()
    _, state = peer.call_for_channel(Request.SAVE, struct.pack("<d", 0.0), peer.channel)
    peer.channel.close()
    state.close()
    assert peer.exit_code() == 0
