"""pysoem reads and writes a drive's EEPROM, and resets its controller; JSON on stdout.

`pysoem_eeprom.py INTERFACE MS alias`: a new alias in the EEPROM shows after a reset.
"""

from typing import Any

from pysoem_bus import PATIENCE_US, Report, run

ALIAS = 0x1234
STATION, STATION_ALIAS, RESET = 0x0010, 0x0012, 0x0040
WORDS = range(8)


def checksum(words: bytes) -> int:
    """CRC-8 of the configuration area: polynomial 7, start value FFh."""
    crc = 0xFF
    for byte in words[:14]:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc


def configuration(drive: Any) -> bytes:
    return b"".join(drive.eeprom_read(word)[:2] for word in WORDS)


def alias(master: Any, report: Report) -> None:
    master.config_init()
    drive = master.slaves[0]
    words = bytearray(configuration(drive))
    report["valid"] = words[14] == checksum(bytes(words))
    report["vendor"] = int.from_bytes(drive.eeprom_read(8), "little")
    words[8:10] = ALIAS.to_bytes(2, "little")
    words[14] = checksum(bytes(words))
    for word in (4, 7):
        drive.eeprom_write(word, bytes(words[2 * word : 2 * word + 2]))
    report["written"] = configuration(drive) == bytes(words)
    report["before"] = int.from_bytes(drive._fprd(STATION_ALIAS, 2, PATIENCE_US), "little")
    for letter in b"RES":
        drive._fpwr(RESET, bytes((letter,)), PATIENCE_US)
    report["count"] = master.config_init()
    report["after"] = int.from_bytes(
        master.slaves[0]._fprd(STATION_ALIAS, 2, PATIENCE_US), "little"
    )


if __name__ == "__main__":
    run({"alias": alias})
