"""Captures are written as tshark reads them, and read as others write them."""

import struct
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame
from achse.monitor.capture import CaptureError, CaptureWriter, read_capture
from achse.router.tap import Captured

CLIENT, PLC = AmsAddress("10.0.0.7.1.1:30000"), AmsAddress("5.0.0.1.1.1:851")
NOW = 1_767_225_600_123_456_789


def _captured(number: int, inwards: bool, size: int, peer: str = "10.0.0.7:5000") -> Captured:
    source, target = (CLIENT, PLC) if inwards else (PLC, CLIENT)
    data = bytes(i & 0xFF for i in range(size))
    frame = Frame(target, source, 2, 4 if inwards else 5, 0, number, data)
    return Captured(NOW + number, inwards, peer, frame.encode())


SOME = [
    _captured(1, True, 12),
    _captured(1, False, 200_000),
    _captured(2, True, 12, "10.0.0.8:50001"),
    _captured(2, False, 0, "10.0.0.8:50001"),
]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "some.pcapng"
    with CaptureWriter(path) as write:
        for capture in SOME:
            write(capture)
        assert write.count == 4
    return path


def test_what_was_written_is_read(file: Path) -> None:
    assert list(read_capture(file)) == SOME


def test_tshark_reads_it(file: Path, witness: Callable[[str], None]) -> None:
    witness("tshark")

    def tshark(display: str, *fields: str) -> list[str]:
        columns = [argument for field in fields for argument in ("-e", field)]
        command = ["tshark", "-r", str(file), "-Y", display, "-T", "fields", *columns]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()

    assert tshark("_ws.malformed", "frame.number") == []
    assert tshark("tcp.analysis.flags", "frame.number") == []
    # it does not put segments together: what continues a long packet is a number of its own
    numbers = [int(number, 0) for number in tshark("ams", "ams.invokeid")]
    assert [number for number in numbers if number < 10] == [1, 1, 2, 2]
    assert tshark("ams && ip.src == 10.0.0.8", "frame.time_epoch")[0].startswith("1767225600.12345")


def test_a_client_inside_the_process_has_an_address_for_the_capture(tmp_path: Path) -> None:
    path = tmp_path / "inside.pcapng"
    with CaptureWriter(path) as write:
        write(_captured(1, True, 4, "127.0.0.1.1.1:32768"))
    [capture] = read_capture(path)
    assert capture.peer == "192.0.2.2:1024"


def _ethernet(capture: Captured, sequence: int, cut: slice = slice(None)) -> bytes:
    packet = struct.pack("<HI", 0, len(capture.packet)) + capture.packet
    data = packet[cut]
    tcp = struct.pack(">HHIIBBHHH", 5000, 48898, sequence, 1, 0x50, 0x18, 1000, 0, 0)
    ip = struct.pack(">BBHHHBBH", 0x45, 0, 40 + len(data), 0, 0, 64, 6, 0)
    ends = bytes([10, 0, 0, 7, 10, 0, 0, 1])
    return bytes(12) + b"\x08\x00" + ip + ends + tcp + data


def _pcap(path: Path, packets: list[bytes]) -> Path:
    head = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 0x40000, 1)
    body = b"".join(
        struct.pack("<IIII", 5, number, len(packet), len(packet)) + packet
        for number, packet in enumerate(packets)
    )
    path.write_bytes(head + body)
    return path


def test_segments_are_put_together_whatever_their_order_and_number(tmp_path: Path) -> None:
    capture = _captured(1, True, 100)
    first = _ethernet(capture, 1000, slice(0, 50))
    second = _ethernet(capture, 1050, slice(50, None))
    for packets in ([first, second], [first, first, second, second]):
        [read] = read_capture(_pcap(tmp_path / "one.pcap", packets))
        assert read.packet == capture.packet
        assert read.peer == "10.0.0.7:5000"
        assert read.time_ns // 1000 == 5_000_000 + packets.index(second)
    late = [first, _ethernet(_captured(2, True, 3), 1138), second]
    assert len(list(read_capture(_pcap(tmp_path / "two.pcap", late)))) == 2


def test_a_gap_and_what_is_no_ams_leave_out_the_rest(tmp_path: Path) -> None:
    capture = _captured(1, True, 100)
    lost = [_ethernet(capture, 1000, slice(0, 50)), _ethernet(capture, 1060, slice(60, None))]
    assert list(read_capture(_pcap(tmp_path / "gap.pcap", lost))) == []
    alien = _captured(1, True, 100)._replace(packet=b"GET / HTTP/1.1")
    assert list(read_capture(_pcap(tmp_path / "alien.pcap", [_ethernet(alien, 1)]))) == []


def test_a_file_that_is_no_capture_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "text.txt"
    path.write_text("no capture")
    with pytest.raises(CaptureError, match="neither pcapng nor pcap"):
        list(read_capture(path))


@given(st.integers(0, 400), st.binary(min_size=1, max_size=4))
def test_a_broken_file_gives_what_can_be_read(tmp_path_factory: Any, at: int, junk: bytes) -> None:
    path = tmp_path_factory.mktemp("broken") / "some.pcapng"
    with CaptureWriter(path) as write:
        write(SOME[0])
        write(SOME[3])
    data = path.read_bytes()
    path.write_bytes(data[:at] + junk + data[at + len(junk) :])
    try:
        for capture in read_capture(path):
            assert isinstance(capture, Captured)
    except CaptureError:
        pass
