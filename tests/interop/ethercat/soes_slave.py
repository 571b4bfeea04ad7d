"""SOES, the open slave stack, as the program behind our slave controller.

`soes_slave.py INTERFACE LIBRARY EEPROM` serves one such slave. SOES reads and writes the controller
as firmware does, through `PdiAccess`; `soes/device.c` has the functions that it calls for that, and
the device's application.
"""

import ctypes
import signal
import subprocess
import sys
from collections.abc import Callable
from ctypes import CFUNCTYPE, POINTER, c_uint8, c_uint16, c_uint32
from pathlib import Path

from achse.ethercat import Loopback, Segment, Slave
from achse.ethercat.clock import Instant
from achse.ethercat.description import MailboxBit
from achse.station.clocks.priority import answer_promptly
from achse.station.slaves.serving import serve_segment
from achse.transport.ethernet import EthernetLink

__all__ = ["SoesSlave", "build", "eeprom_of"]

DEVICE = Path(__file__).parent / "soes"
DEMO = "applications/linux_lan9252demo"
MODULES = ("ecat_slv", "esc", "esc_coe", "esc_foe", "esc_eoe")
POLL_NS = 100_000
POLLS_WITHOUT_OUTPUTS = 1000
"""Watchdog of SOES, 100 ms."""
FILE_SIZE = 4096
_PROTOCOLS_AT = 0x38
_ACCESS = CFUNCTYPE(None, c_uint16, POINTER(c_uint8), c_uint16)


def build(source: Path, into: Path) -> Path:
    """Build the stack, the demo's object list and our device from the source of SOES."""
    library = into / "soes.so"
    folders = (DEVICE, source / "soes", source / "soes/include/sys/gcc", source / DEMO)
    command = [
        *("cc", "-shared", "-fPIC", "-O1", "-w"),
        *(f"-I{each}" for each in folders),
        *(source / "soes" / f"{each}.c" for each in MODULES),
        *(source / DEMO / "slave_objectlist.c", DEVICE / "device.c", "-o", library),
    ]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return library


def eeprom_of(source: Path) -> bytes:
    """The demo's EEPROM; it says EoE too, since the device has it."""
    image = bytearray((source / DEMO / "slave.bin").read_bytes().ljust(2048, b"\xff"))
    image[_PROTOCOLS_AT] |= MailboxBit.EOE
    return bytes(image)


class SoesSlave(Slave):
    """A slave whose program is SOES, which polls: events of the controller are ignored.

    SOES keeps its state in the library: a second slave needs a copy of the file.
    """

    def __init__(self, library: Path, image: bytes) -> None:
        self._stack: ctypes.CDLL | None = None
        super().__init__(Loopback(), sii=image)
        self._time = Instant()
        self._reader = _ACCESS(self._read)
        self._writer = _ACCESS(self._write)
        self.refused: list[int] = []
        """Addresses that SOES wrote and a device must not write."""
        self._stack = ctypes.CDLL(str(library))
        self._start()

    def _start(self) -> None:
        assert self._stack is not None
        self._stack.soes_start(self._reader, self._writer, POLLS_WITHOUT_OUTPUTS)
        self.due_ns = self._time.now_ns + POLL_NS

    def _read(self, address: int, data: "ctypes._Pointer[c_uint8]", length: int) -> None:
        ctypes.memmove(data, self.esc.pdi_access.read(address, length), length)

    def _write(self, address: int, data: "ctypes._Pointer[c_uint8]", length: int) -> None:
        if not self.esc.pdi_access.write(address, ctypes.string_at(data, length)):
            self.refused.append(address)

    @property
    def file(self) -> bytes:
        """The file that came by FoE."""
        assert self._stack is not None
        size = c_uint32.in_dll(self._stack, "soes_file_size").value
        return bytes((c_uint8 * FILE_SIZE).in_dll(self._stack, "soes_file"))[:size]

    def join(self, time: Instant) -> None:
        """Share the time of a segment."""
        self._time = self.esc.time = self.esc.clock.time = time

    def advance(self, now_ns: int) -> None:
        """Poll the stack."""
        assert self._stack is not None
        while self.due_ns <= now_ns:
            self._time.now_ns = self.due_ns
            self.due_ns += POLL_NS
            self._stack.soes_poll()

    def reset(self) -> None:
        """Start again: the master reset the controller."""
        self.esc.power_up()
        self._start()

    def al_control(self, request_word: int) -> None:
        """Ignore the event."""

    def sync_manager_changed(self, number: int) -> None:
        """Ignore the event."""

    def written(self, number: int, data: bytes) -> None:
        """Ignore the event."""

    def taken(self, number: int) -> None:
        """Ignore the event."""

    def looked_at(self, number: int) -> None:
        """Ignore the event."""

    def timing_changed(self) -> None:
        """Ignore the event."""


def main() -> None:
    interface, library, image = sys.argv[1:]
    segment = Segment([SoesSlave(Path(library), Path(image).read_bytes())])
    link = EthernetLink(interface)
    running = True

    def stop(*_: object) -> None:
        nonlocal running
        running = False

    signal.signal(signal.SIGTERM, stop)
    answer_promptly()
    print("ready", flush=True)
    serve: Callable[..., None] = serve_segment
    serve(segment, link, lambda: running)


if __name__ == "__main__":
    main()
