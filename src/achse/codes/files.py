"""Errors with which a slave refuses a file by mailbox (FoE).

Source: ETG.1000.6 §5.8.
"""

from enum import IntEnum


class FoeError(IntEnum):
    """Error code of a refused file."""

    UNDEFINED = 0x8000
    NOT_FOUND = 0x8001
    ACCESS_DENIED = 0x8002
    DISK_FULL = 0x8003
    ILLEGAL = 0x8004
    PACKET_NUMBER = 0x8005
    ALREADY_EXISTS = 0x8006
    NO_USER = 0x8007
    BOOTSTRAP_ONLY = 0x8008
    NOT_IN_BOOTSTRAP = 0x8009
    NO_RIGHTS = 0x800A
    PROGRAM_ERROR = 0x800B


class FileRefusal(Exception):
    """A device refuses a file with `code`; `reason` travels with it."""

    def __init__(self, code: FoeError, reason: str = "") -> None:
        super().__init__(f"0x{code:04X} {code.name.replace('_', ' ').lower()} {reason}".rstrip())
        self.code = code
        self.reason = reason
