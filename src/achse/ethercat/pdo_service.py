"""PDOs by mailbox, the slave's end: read and written whole, as they are mapped.

Source: ETG.1000.6 §5.6.4 (TxPDO, RxPDO and their remote requests); 001 has none.
"""

from collections.abc import Iterator, Mapping

from achse.codes import AbortCode, SdoAbort
from achse.ethercat.application import Application, ObjectDescription

RX_PDO, TX_PDO = 0x1600, 0x1A00
"""The mapping of PDO 0 of each direction; a message has the number of the PDO, 0 to 511."""


class PdoService:
    """The PDOs of an application, from its dictionary."""

    def __init__(self, application: Application, objects: Mapping[int, ObjectDescription]) -> None:
        self._application = application
        self._objects = objects

    def read(self, index: int) -> bytes:
        """Return the bytes of the PDO whose mapping is at `index`; raises `SdoAbort`."""
        value = at = 0
        for entry, subindex, bits in self._entries(index):
            if entry:
                data = self._application.read_object(entry, subindex)
                value |= (int.from_bytes(data, "little") & (1 << bits) - 1) << at
            at += bits
        return value.to_bytes(at + 7 >> 3, "little")

    def write(self, index: int, data: bytes) -> None:
        """Write what a PDO has mapped; raises `SdoAbort` for a wrong length and what is refused."""
        entries = list(self._entries(index))
        if len(data) != sum(bits for *_, bits in entries) + 7 >> 3:
            raise SdoAbort(AbortCode.LENGTH)
        value = int.from_bytes(data, "little")
        for entry, subindex, bits in entries:
            part = value & (1 << bits) - 1
            value >>= bits
            if entry:
                self._application.write_object(
                    entry, subindex, part.to_bytes(bits + 7 >> 3, "little")
                )

    def _entries(self, index: int) -> Iterator[tuple[int, int, int]]:
        """Index, subindex and bits of what is mapped; index 0 pads."""
        if index not in self._objects:
            raise SdoAbort(AbortCode.NO_OBJECT)
        read = self._application.read_object
        for subindex in range(1, read(index, 0)[0] + 1):
            mapped = int.from_bytes(read(index, subindex), "little")
            yield mapped >> 16, mapped >> 8 & 0xFF, mapped & 0xFF
