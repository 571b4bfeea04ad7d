"""SOES, the open slave stack, behind our slave controller: our master and pysoem bring it to Op."""

import os
import shutil
from collections.abc import Callable, Generator
from dataclasses import replace
from ipaddress import IPv4Address
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Segment
from achse.ethercat.eoe import IpSettings, MacFilter
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master import BusConfiguration, Master, Ring
from achse.ethercat.master.eoe_client import EoeRefusal
from achse.ethercat.master.errors import BusError, MailboxRefusal, SdoRefusal
from achse.ethercat.master.foe_client import FoeClient, FoeRefusal
from tests.ethercat.master.test_scanning import scan
from tests.interop.ethercat.soes_slave import SoesSlave, build, eeprom_of

SOURCE = Path(os.environ.get("ACHSE_SOES", ""))
"""The source of SOES; no package registry has it."""
CYCLE_NS = 1_000_000
OP = 8
IDENTITY = (0x1337, 1234, 0, 0)
ADDRESSES = IpSettings(
    b"\x02\0\0\0\0\x07",
    IPv4Address("10.0.0.7"),
    IPv4Address("255.255.255.0"),
    IPv4Address("10.0.0.1"),
    IPv4Address("10.0.0.2"),
    "soes",
)

pytestmark = [
    pytest.mark.skipif(not (SOURCE / "soes/esc.c").is_file(), reason="ACHSE_SOES names no source"),
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler on this machine"),
]


class Bus:
    """Our master and the slave, in virtual time."""

    def __init__(self, library: Path) -> None:
        self.slave = SoesSlave(library, eeprom_of(SOURCE))
        self.segment = Segment([self.slave])
        (self.scanned,) = scan(self.segment)
        self.master = Master(BusConfiguration((self.scanned.configuration,), cycle_ns=CYCLE_NS))
        self.ring = Ring(self.master, self.segment)
        self.now_ns = self.segment.time.now_ns
        self.seen: Any = self.master.slaves[0]

    def run(self, cycles: int = 1) -> None:
        """Let cycles pass."""
        for _ in range(cycles):
            self.now_ns += CYCLE_NS
            self.ring.exchange(self.now_ns)

    def until(self, reached: Callable[[], bool]) -> None:
        """Let cycles pass until something is so."""
        for _ in range(5000):
            if reached():
                return
            self.run()
        pytest.fail(f"not reached: {[each.text for each in self.master.take_events()][-5:]}")

    def up(self, state: AlState = AlState.OP) -> "Bus":
        """Bring it to a state."""
        self.master.request(state)
        self.until(lambda: self.seen.state == state and (state < OP or self.master.operational))
        return self

    def do(self, steps: Generator[Any, Any, Any]) -> Any:
        """Do steps and return their value."""
        job = self.master.run(steps)
        self.until(lambda: job.is_done)
        return job.result()


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(SOURCE, tmp_path_factory.mktemp("soes"))


@pytest.fixture
def ours(library: Path) -> Bus:
    return Bus(library)


def test_our_master_brings_it_to_op_and_exchanges(ours: Bus) -> None:
    assert (ours.scanned.trouble, ours.scanned.facts.identity) == ("", IDENTITY)
    ours.up()
    sdo, wrong = ours.seen.sdo, ours.seen.wrong_cycles
    assert ours.do(sdo.upload(0x1008, 0)) == b"evb9252_dig"
    ours.do(sdo.download(0x8000, 1, (3).to_bytes(4, "little")))
    for first, second in ((1, 2), (200, 20), (255, 255)):
        ours.seen.write_output(0x7000, 1, first)
        ours.seen.write_output(0x7000, 2, second)
        ours.run(3)
        assert ours.seen.read_input(0x6000, 1) == (first + 3 * second) % 256
    assert (ours.seen.wrong_cycles - wrong, ours.slave.refused) == (0, [])


def test_objects_are_described_and_refused(ours: Bus) -> None:
    ours.up(AlState.PREOP)
    sdo = ours.seen.sdo
    indices = ours.do(sdo.object_list())
    assert {0x1000, 0x1018, 0x1600, 0x1A00, 0x1C12, 0x6000, 0x7000, 0x8000} <= set(indices)
    assert ours.do(sdo.object_information(0x8000)).name == "Parameters"
    assert ours.do(sdo.entry_information(0x8000, 1)).rest == b"Multiplier"
    for write, index, subindex, number in (
        (False, 0x2222, 0, 0x0602_0000),
        (False, 0x8000, 9, 0x0609_0011),
        (True, 0x1000, 0, 0x0601_0002),
    ):
        steps = sdo.download(index, subindex, bytes(4)) if write else sdo.upload(index, subindex)
        with pytest.raises(SdoRefusal) as refusal:
            ours.do(steps)
        assert refusal.value.number == number


@settings(max_examples=10, deadline=None)
@given(st.binary(min_size=1, max_size=4000), st.binary(min_size=60, max_size=1200))
def test_files_and_frames(library: Path, file: bytes, frame: bytes) -> None:
    """FoE writes its file; EoE sets addresses, and a frame comes back from its port."""
    ours = Bus(library).up(AlState.PREOP)
    foe = FoeClient(ours.seen.mailbox)
    ours.do(foe.write("firmware.bin", file, 0xBEEF))
    assert ours.slave.file[: len(file)] == file
    with pytest.raises(FoeRefusal, match="0x8001"):
        ours.do(foe.write("other", file))
    with pytest.raises(FoeRefusal, match="0x800A"):
        ours.do(foe.write("firmware.bin", file, 1))
    eoe = ours.seen.eoe
    ours.do(eoe.set_ip(ADDRESSES))
    assert ours.do(eoe.get_ip()) == ADDRESSES
    came: list[bytes] = []
    eoe.take = came.append
    ours.do(eoe.send(frame))
    ours.until(lambda: bool(came))
    assert came == [frame[6:12] + frame[:6] + frame[12:]]
    with pytest.raises((EoeRefusal, BusError)):
        ours.do(eoe.set_filter(MacFilter()))


def test_protocol_that_it_does_not_speak_is_a_mailbox_error(ours: Bus) -> None:
    ours.up(AlState.PREOP)
    mailbox = ours.seen.mailbox
    assert mailbox is not None
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(mailbox.converse(MailboxProtocol.SOE, b"\x01\x40\x20\0", lambda data: True))


def test_it_refuses_what_is_wrong_and_comes_back(ours: Bus) -> None:
    """Another place of the outputs, a jump of states, missing outputs."""

    wrong = replace(ours.scanned.configuration, outputs=())
    master = Master(BusConfiguration((wrong,), cycle_ns=CYCLE_NS))
    ring = Ring(master, ours.segment)
    master.request(AlState.OP)
    for _ in range(200):
        ours.now_ns += CYCLE_NS
        ring.exchange(ours.now_ns)
    assert master.slaves[0].state & 0x0F == AlState.PREOP
    assert "0x001D" in master.slaves[0].last_trouble.upper().replace("0X", "0x")
    ours.up()
    ours.segment.advance(ours.now_ns + 200_000_000)  # its watchdog
    ours.now_ns += 200_000_000
    assert ours.slave.esc.memory[0x0130] == 0x14
    ours.until(lambda: not ours.master.operational)
    ours.up()


def test_pysoem_brings_it_to_op(
    bus: Any, witness: Callable[[str], None], library: Path, tmp_path: Path
) -> None:
    """Master and slave by others, our controller between them."""
    witness("pysoem")
    image = tmp_path / "eeprom.bin"
    image.write_bytes(eeprom_of(SOURCE))
    bus.slaves("soes_slave.py", library, image)
    report = bus.master("pysoem_esi.py")
    assert (report["count"], report["states"]) == (1, [OP]), report["codes"]
    assert report["sizes"] == [[2, 1]]
