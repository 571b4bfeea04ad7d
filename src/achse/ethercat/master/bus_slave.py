"""A slave as the master sees it: process data, state, mailbox, counters.

Source: ETG.1510 for the diagnosis; ETG.1000.4 §6.1 for what is read of the controller.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter

from achse.codes import AlState
from achse.ethercat.master.aoe_client import AoeClient
from achse.ethercat.master.configuration import SlaveConfiguration
from achse.ethercat.master.eeprom_client import EepromClient
from achse.ethercat.master.eoe_client import EoeClient
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.process_image import EntryPlace, ProcessDatagram, entry_places
from achse.ethercat.master.sdo_client import SdoClient
from achse.ethercat.master.soe_client import SoeClient
from achse.ethercat.master.voe_client import VoeClient

PORTS = 4
_OP = int(AlState.OP)
_VALID = attrgetter("valid")
_MAILBOX_STATES = (AlState.PREOP, AlState.SAFEOP, AlState.OP)

_BYTES_ONLY, _CLOCK, _WIDE_CLOCK, _NO_LOGICAL_READ_WRITE = 1 << 0, 1 << 2, 1 << 3, 1 << 9
"""Bits of the features."""


@dataclass
class SlaveFacts:
    """Facts read from the controller: counts of FMMUs and SyncManagers, features, DL status.

    `identity` is vendor, product, revision, serial number.
    """

    controller: int = 0
    fmmus: int = 0
    sync_managers: int = 0
    ports: int = 0
    features: int = 0
    dl_status: int = 0
    identity: tuple[int, int, int, int] = (0, 0, 0, 0)
    delay_ns: int = 0

    @property
    def has_clock(self) -> bool:
        """True if the slave has a distributed clock."""
        return bool(self.features & _CLOCK)

    @property
    def maps_bits(self) -> bool:
        """True if the FMMUs count in bits, not in bytes."""
        return not self.features & _BYTES_ONLY

    @property
    def wide_clock(self) -> bool:
        """True if the clock has 64 bits."""
        return bool(self.features & _WIDE_CLOCK)

    @property
    def logical_read_write(self) -> bool:
        """True if the slave supports LRW."""
        return not self.features & _NO_LOGICAL_READ_WRITE


@dataclass
class PortCounters:
    """Errors since the last reset, by port: invalid frames and RX errors, lost links."""

    errors: list[int] = field(default_factory=lambda: [0] * PORTS)
    forwarded: list[int] = field(default_factory=lambda: [0] * PORTS)
    lost_links: list[int] = field(default_factory=lambda: [0] * PORTS)


class BusSlave:
    """One configured slave.

    `state` is AL status bits 0..3 as last seen (0: it does not answer), `error` whether its error
    bit is on, `al_code` why. `wanted` is the state that it shall have. `outputs` and `inputs` are
    memory: what is written to `outputs` goes out with the next cycle, `inputs` are the last valid
    ones. Entries are found by (index, subindex).
    """

    def __init__(
        self,
        position: int,
        station: int,
        configuration: SlaveConfiguration,
        outputs: memoryview,
        inputs: memoryview,
        owners: tuple[ProcessDatagram | None, ProcessDatagram | None],
        emergency: Callable[["BusSlave", bytes], None],
    ) -> None:
        self.position = position
        self.station = station
        self.configuration = configuration
        self.name = configuration.name
        self.outputs = outputs
        self.inputs = inputs
        self.output_entries: Mapping[tuple[int, int], EntryPlace] = _by_key(configuration, True)
        self.input_entries: Mapping[tuple[int, int], EntryPlace] = _by_key(configuration, False)
        self.facts = SlaveFacts()
        self.counters = PortCounters()
        self.state = 0
        self.error = False
        self.al_code = 0
        self.requested_state = AlState.INIT
        self.present = False
        self.mismatch = False
        self.failed_command = False
        """True if a start command was refused."""
        self.abnormal_changes = 0
        """Number of state changes that the master did not request."""
        self.losses = 0
        """Number of times that the slave stopped answering."""
        self.clock_difference_ns = 0
        self.output_shift_ns = 0
        """From the cycle in which outputs are computed to SYNC0, when they act."""
        self.reads_mailbox_bit = False
        self.last_trouble = ""
        """Reason why the slave does not reach its state, empty if it does."""
        self._owners = tuple({id(each): each for each in owners if each is not None}.values())
        self.eeprom = EepromClient(station)
        self.mailbox: MailboxClient | None = None
        self.sdo: SdoClient | None = None
        self.aoe: AoeClient | None = None
        self.eoe: EoeClient | None = None
        self.soe: SoeClient | None = None
        self.voe: VoeClient | None = None
        out, into, times = configuration.mailbox_out, configuration.mailbox_in, configuration.times
        if out is not None and into is not None:
            self.mailbox = MailboxClient(
                station,
                out,
                into,
                lambda data: emergency(self, data),
                request_ns=times.request_ns,
                response_ns=times.response_ns,
                split_writes=configuration.split_mailbox_writes,
            )
            self.aoe = AoeClient(self.mailbox)
            self.eoe = EoeClient(self.mailbox)
            self.soe = SoeClient(self.mailbox)
            self.voe = VoeClient(self.mailbox)
            if configuration.coe:
                self.sdo = SdoClient(self.mailbox)

    @property
    def speaks(self) -> bool:
        """True if the slave answers, and its mailbox works: PreOp, SafeOp or Op."""
        return self.mailbox is not None and self.present and self.state in _MAILBOX_STATES

    @property
    def working(self) -> bool:
        """True if all its process data came with the right working counter in the last cycle."""
        return all(map(_VALID, self._owners))

    @property
    def wrong_cycles(self) -> int:
        """Cycles in which its process data were missing or had a wrong working counter."""
        return max((each.wrong for each in self._owners), default=0)

    @property
    def input_toggle(self) -> bool:
        """Changes with each cycle that came back valid."""
        return bool(self._owners and self._owners[-1].fresh & 1)

    @property
    def operational(self) -> bool:
        """True if the slave is in Op without an error, and its process data are valid."""
        return self.state == _OP and not self.error and all(map(_VALID, self._owners))

    def read_input(self, index: int, subindex: int = 0, *, signed: bool = False) -> int:
        """Return the value of an input entry; KeyError if it is not mapped."""
        return _read(self.inputs, self.input_entries[index, subindex], signed)

    def read_output(self, index: int, subindex: int = 0, *, signed: bool = False) -> int:
        """Return the value that an output entry has now; KeyError if it is not mapped."""
        return _read(self.outputs, self.output_entries[index, subindex], signed)

    def write_output(self, index: int, subindex: int, value: int) -> None:
        """Write an output entry, cut to its bits; KeyError if it is not mapped."""
        place = self.output_entries[index, subindex]
        first, shift = place.byte, place.bit & 7
        length = shift + place.bits + 7 >> 3
        memory = self.outputs[first : first + length]
        mask = (1 << place.bits) - 1
        if not shift and not place.bits & 7:
            memory[:] = (value & mask).to_bytes(length, "little")
            return
        present = int.from_bytes(memory, "little") & ~(mask << shift)
        memory[:] = (present | (value & mask) << shift).to_bytes(length, "little")


def _read(memory: memoryview, place: EntryPlace, signed: bool) -> int:
    first, shift = place.byte, place.bit & 7
    length = shift + place.bits + 7 >> 3
    value = int.from_bytes(memory[first : first + length], "little") >> shift
    value &= (1 << place.bits) - 1
    if signed and value >> place.bits - 1:
        value -= 1 << place.bits
    return value


def _by_key(slave: SlaveConfiguration, output: bool) -> dict[tuple[int, int], EntryPlace]:
    return {(each.index, each.subindex): each for each in entry_places(slave, output)}
