"""Interface of the scope between devices and clients: port, index groups, words.

Texts are UTF-8, what has structure is JSON; times are Unix time in ns.
"""

import struct
from enum import IntEnum, StrEnum

SCOPE_PORT = 14_000
"""The AMS port (000 §5.2)."""


class ScopeGroup(IntEnum):
    """Index groups."""

    ROOT_STATES = 0x1000
    """Online, offline (000 §5.2)."""
    ROOT_FUNCTIONS = 0x2000
    """Load a file (000 §5.2)."""
    VIEW = 0x3000
    """The one view, id 1 (000 §5.2)."""
    SCOPES = 0xFA10
    """Ours. Offset 0: Read lists all scopes, ReadWrite makes one of a definition. Offset = number:
    Read returns its state, ReadWrite commands it."""
    SAMPLES = 0xFA11
    """Ours. Offset = number: ReadWrite gives samples in the binary form."""


class ScopeCommand(StrEnum):
    """Command in a ReadWrite to `SCOPES` at a scope's number."""

    START = "start"
    STOP = "stop"
    TRIGGER = "trigger"
    CLOSE = "close"
    PROGRESS = "progress"
    """Returns state and counts, and changes nothing."""


SAMPLES_REQUEST = struct.Struct("<IQ")
"""Numbers of the channel group and of the first row; the answer is a chunk
(`achse.scope.binary`)."""
