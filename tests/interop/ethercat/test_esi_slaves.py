"""Slaves made from ESI files: masters by others bring them to Op through a network interface."""

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.ethercat.virtual.esi_text import ANALOG, COUPLER, DIGITAL_IN, DIGITAL_OUT, esi
from tests.fuzz.bus_attacks import Attacker
from tests.interop.ethercat.pysoem_suite_slaves import write_files

OP = 8
SUITE = os.environ.get("ACHSE_PYSOEM_TESTS", "")
"""Folder of pysoem's own tests, of the version that is installed."""
OURS = Path(__file__).with_name("pysoem_suite_slaves.py")


@pytest.fixture
def line(bus: Any, tmp_path: Path) -> Any:
    """A coupler, two digital terminals and an analog one that gives back what it gets."""
    file = tmp_path / "boxes.xml"
    file.write_text(esi(COUPLER, DIGITAL_IN, DIGITAL_OUT, ANALOG))
    ready = bus.serve(
        *(bus.achse, "bus", "serve", "EK", "DI8", "DO8", "AIO"),
        *("--esi", file, "--behaviour", "4=loop-back", "--interface", "cable1"),
        *("--control", "none"),
    )
    assert ready == "achse bus ready interface=cable1 slaves=4 control=none\n"
    return bus


def test_pysoem(line: Any, judge: Callable[[Path], int], witness: Callable[[str], None]) -> None:
    witness("pysoem")
    line.record()
    report = line.master("pysoem_esi.py")
    line.end_record()
    assert report["count"] == 4
    assert report["names"] == ["EK", "DI8", "DO8", "AIO"]
    assert report["states"] == [OP] * 4, report["codes"]
    assert report["sizes"] == [[0, 0], [0, 1], [1, 0], [2, 4]]
    assert report["counter"][0] == report["counter"][1]
    assert report["inputs"][3] == report["sent"][3] + "0000"
    assert judge(line.capture) > 100


def test_pysoem_after_an_attack(line: Any, witness: Callable[[str], None], tmp_path: Path) -> None:
    """What a hostile master and somebody with other protocols send harms no master after them."""
    witness("pysoem")
    attacker = Attacker(7, 4)
    packets = [*attacker.frames(1500, lasting=False)]
    for number, packet in enumerate(packets[::5]):
        other = bytearray(packet)
        other[12:14] = (b"\x08\x00", b"\x81\x00", b"\x00\x00", b"\x88\xa4")[number % 4]
        packets.append(bytes(other[: 14 + number % 60]))
    file = tmp_path / "frames"
    file.write_bytes(b"".join(len(each).to_bytes(2, "little") + each for each in packets))
    for _ in range(2):
        sent = line.master("attack.py", file)
        assert sent["sent"] == len(packets)
        report = line.master("pysoem_esi.py")
        assert report["states"] == [OP] * 4, report["codes"]
        assert report["counter"][0] == report["counter"][1]


@pytest.mark.skipif(not SUITE, reason="ACHSE_PYSOEM_TESTS names no folder")
def test_own_tests_of_pysoem(bus: Any, witness: Callable[[str], None], tmp_path: Path) -> None:
    """All but those that its authors skip, on the slaves that they were written for."""
    witness("pysoem")
    write_files(tmp_path)
    types = ("XMC43-Test-Device", "EK1100", "EL3002", "EL1259")
    bus.serve(
        *(sys.executable, "-m", "achse", "bus", "serve", *types, "--esi", tmp_path),
        *("--behaviour", f"1={OURS}:Board", "--behaviour", f"4={OURS}:Stamps"),
        *("--interface", "cable1", "--control", "none"),
    )
    files = sorted(Path(SUITE).glob("pysoem_*_test.py"))
    command = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "/dev/null")
    printed = bus.run(*command, "--rootdir", SUITE, *files, "--ifname", "cable0")
    assert re.search(r"[0-9]+ passed, 2 skipped in", printed), printed


def test_kickcat(line: Any, witness: Callable[[str], None]) -> None:
    witness("kickcat")
    report = line.master("kickcat_esi.py")
    assert report["count"] == 4
    assert report["op"] == ["State.OPERATIONAL"] * 4
    assert report["inputs"][1:] == ["00", "", "00000000"]
