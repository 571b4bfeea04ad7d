"""Interface of a device behind a slave controller: objects, process data, local cycle, state
checks.

A device implements this protocol by structure; it imports nothing of EtherCAT. The shared codes
(`AlState`, `AlStatus`, `AbortCode`, `SdoAbort`) are in `achse.codes`.

Source: ETG.1000.6, the device behind its controller.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import IntEnum, IntFlag
from typing import Protocol, runtime_checkable

from achse.codes import AlState, AlStatus


class ObjectCode(IntEnum):
    """Kind of an object."""

    DOMAIN = 2
    VAR = 7
    ARRAY = 8
    RECORD = 9


class ObjectAccess(IntFlag):
    """Access word of an entry: in which states it is read and written, and what it may join."""

    READ_PREOP = 0x0001
    READ_SAFEOP = 0x0002
    READ_OP = 0x0004
    WRITE_PREOP = 0x0008
    WRITE_SAFEOP = 0x0010
    WRITE_OP = 0x0020
    RX_PDO = 0x0040
    TX_PDO = 0x0080
    BACKUP = 0x0100
    SETTINGS = 0x0200
    READ = 0x0007
    WRITE = 0x0038


class Identity(Protocol):
    """Identity of the device (object 1018h), each number a u32."""

    @property
    def vendor_id(self) -> int: ...
    @property
    def product_code(self) -> int: ...
    @property
    def revision_number(self) -> int: ...
    @property
    def serial_number(self) -> int: ...


class ObjectEntry(Protocol):
    """One subindex of an object.

    `data_type` is a `DataType` number, `bits` the length, `access` an `ObjectAccess` word.
    `default`, `minimum` and `maximum` are little-endian bytes of that length, None where there is
    none.
    """

    @property
    def subindex(self) -> int: ...
    @property
    def name(self) -> str: ...
    @property
    def data_type(self) -> int: ...
    @property
    def bits(self) -> int: ...
    @property
    def access(self) -> int: ...
    @property
    def default(self) -> bytes | None: ...
    @property
    def minimum(self) -> bytes | None: ...
    @property
    def maximum(self) -> bytes | None: ...


class ObjectDescription(Protocol):
    """One object: VAR objects have the entry of subindex 0 alone, others also the count there."""

    @property
    def index(self) -> int: ...
    @property
    def name(self) -> str: ...
    @property
    def code(self) -> int: ...
    @property
    def data_type(self) -> int: ...
    @property
    def entries(self) -> Sequence[ObjectEntry]: ...


class Application(Protocol):
    """A device behind an EtherCAT slave controller (the PDI side).

    All is called from one thread, in virtual time; nothing here waits.
    """

    @property
    def name(self) -> str:
        """Name of the device type, at most 255 bytes of ASCII; goes to SII and ESI."""
        ...

    @property
    def identity(self) -> Identity: ...

    def objects(self) -> Iterable[ObjectDescription]:
        """Return the dictionary, by ascending index; it does not change."""
        ...

    def read_object(self, index: int, subindex: int) -> bytes:
        """Return the value, little-endian; raises `SdoAbort`."""
        ...

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Take a value over, or raise `SdoAbort`; a wrong length is the application's to refuse."""
        ...

    @property
    def output_size(self) -> int:
        """Bytes of the active RxPDO mapping; constant outside PreOp."""
        ...

    @property
    def input_size(self) -> int:
        """Bytes of the active TxPDO mapping; constant outside PreOp."""
        ...

    def write_outputs(self, data: bytes) -> None:
        """Accept outputs, `output_size` bytes; called in Op only, once for each SM2 event."""
        ...

    def read_inputs(self) -> bytes:
        """Return the newest inputs, always exactly `input_size` bytes; called in SafeOp and Op."""
        ...

    def enter(self, state: AlState, sync0_ns: int, cause: AlStatus) -> AlStatus:
        """The slave is about to enter `state`; anything but NO_ERROR refuses.

        `sync0_ns` is the SYNC0 cycle, 0 in FreeRun. `cause` is NO_ERROR for what the master
        requested; else it is why the slave falls to `state` (watchdog, lost synchronisation, …),
        and the answer is not looked at. Staying in one state is not reported.
        """
        ...

    def step(self, elapsed_ns: int) -> AlStatus:
        """Return the local cycle: time passed, in FreeRun a multiple of `local_cycle_ns`, with DC
        one SYNC0 cycle. Anything but NO_ERROR drops the slave to that code's result state."""
        ...

    @property
    def local_cycle_ns(self) -> int:
        """Period of the local timer in FreeRun."""
        ...

    def take_emergency(self) -> bytes | None:
        """Return the oldest emergency message not yet taken, 8 bytes; None if there is none."""
        ...


@runtime_checkable
class BufferedApplication(Protocol):
    """An application with process data in several SyncManagers of one direction.

    These take the place of `output_size`, `input_size`, `write_outputs` and `read_inputs`.
    """

    def buffer_size(self, number: int) -> int:
        """Return bytes of process data in SyncManager `number`; constant outside PreOp."""
        ...

    def buffer_writer(self, number: int) -> Callable[[bytes], object]:
        """Return the receiver of the outputs of SyncManager `number`, from SafeOp on until PreOp;
        called in Op only."""
        ...

    def buffer_reader(self, number: int) -> Callable[[], bytes]:
        """Return the reader of the newest inputs of SyncManager `number`, from SafeOp on until
        PreOp."""
        ...


@runtime_checkable
class QuietApplication(Protocol):
    """An application that knows without a look at its messages that none waits for the master."""

    @property
    def is_quiet(self) -> bool:
        """False if there may be an emergency, or a message that it sends by itself."""
        ...


@runtime_checkable
class MessagingApplication(Protocol):
    """An application whose mailbox speaks protocols of its own: AoE (1), EoE (2), VoE (15), …"""

    @property
    def services(self) -> Mapping[int, Callable[[bytes], Iterable[bytes] | int]]:
        """Message handlers by protocol: each maps request data to the data of the replies, or to
        the detail of a mailbox error. Handlers raise nothing."""
        ...

    def take_message(self) -> tuple[int, bytes] | None:
        """Return the oldest message that it sends by itself: protocol and data; None if there is
        none."""
        ...


@runtime_checkable
class FileApplication(Protocol):
    """An application whose mailbox reads and writes files (FoE).

    What refuses a file raises `achse.codes.FileRefusal`.
    """

    @property
    def bootstrap(self) -> bool:
        """True if the device has the state Bootstrap."""
        ...

    @property
    def longest_file(self) -> int:
        """Bytes of the longest file that may be written."""
        ...

    @property
    def programming(self) -> tuple[int, int] | None:
        """Progress of programming the file written last: bytes in place, and of all; None when
        complete."""
        ...

    def read_file(self, name: str, password: int) -> bytes:
        """Return a whole file."""
        ...

    def begin_file(self, name: str, password: int) -> None:
        """Refuse a file that must not be written."""
        ...

    def write_file(self, name: str, data: bytes) -> None:
        """Take over a whole file; `programming` reports its progress."""
        ...
