"""The firmware file of a drive: read and written as a file, programmed in its time.

The manual of the drive names none; name, password and times are ours.
"""

from achse.codes import FileRefusal, FoeError

LONGEST_FIRMWARE = 1 << 20
"""Bytes that the drive has room for."""

_NS_PER_BYTE = 10_000
"""Programming takes: 100 kB a second."""


class Firmware:
    """One file. `content` is what the drive has; `bootstrap`: it is written in Bootstrap alone.

    A file that is written replaces the content when it is programmed, not before: a drive that is
    reset in between has the old one.
    """

    def __init__(
        self,
        name: str = "firmware.bin",
        content: bytes = b"virtual servo drive, firmware 1.0\n",
        *,
        password: int = 0,
        bootstrap: bool = False,
    ) -> None:
        self.name = name
        self.content = content
        self.password = password
        self.bootstrap = bootstrap
        self.write_count = 0
        """Number of times that other firmware was programmed."""
        self._new = b""
        self._left_ns = 0

    def check(self, name: str, password: int) -> None:
        """Raise `FileRefusal` for another name or password."""
        if name != self.name:
            raise FileRefusal(FoeError.NOT_FOUND, f"the file is {self.name}")
        if password != self.password:
            raise FileRefusal(FoeError.NO_RIGHTS, "wrong password")

    def program(self, content: bytes) -> None:
        """Begin to program; raises `FileRefusal` for content that cannot be firmware."""
        if not content:
            raise FileRefusal(FoeError.PROGRAM_ERROR, "the file is empty")
        if len(content) > LONGEST_FIRMWARE:
            raise FileRefusal(FoeError.DISK_FULL, f"{LONGEST_FIRMWARE} bytes at most")
        self._new = content
        self._left_ns = len(content) * _NS_PER_BYTE

    @property
    def programming(self) -> tuple[int, int] | None:
        """Number of bytes programmed, and of all; None while nothing is programmed."""
        if not self._new:
            return None
        return len(self._new) - -(-self._left_ns // _NS_PER_BYTE), len(self._new)

    def advance(self, elapsed_ns: int) -> None:
        """Advance the time that programming takes."""
        if not self._new:
            return
        self._left_ns = max(self._left_ns - elapsed_ns, 0)
        if not self._left_ns:
            self.content, self._new = self._new, b""
            self.write_count += 1

    def abandon(self) -> None:
        """Note that the drive is switched off: what is not programmed is lost."""
        self._new = b""
