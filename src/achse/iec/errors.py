"""The error tree of IEC types.

IecError
├── DeclarationError   a type or variable that cannot exist as declared
├── IecValueError      a Python value that does not fit the type
├── IecDecodeError     bytes that are not a value, symbol entry or type entry
├── IecPathError       an instance path that leads nowhere
│   └── IecIndexError  … because an index is outside the bounds of its array
└── UnboundError       a declared variable used before it has memory
"""

_LONGEST = 80


def shown(value: object) -> str:
    """`repr(value)` cut to a length that fits into a message, whatever the value."""
    if isinstance(value, int) and value.bit_length() > 256:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, str | bytes | bytearray) and len(value) > _LONGEST:
        return f"{bytes(value[:40])!r}…" if not isinstance(value, str) else f"{value[:40]!r}…"
    try:
        text = repr(value)
    except Exception:
        return f"a {type(value).__name__}"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


class IecError(Exception):
    """Anything that goes wrong between Python and IEC 61131-3 types."""


class DeclarationError(IecError):
    """A type or variable cannot be declared like this; says what was expected and what came."""


class IecValueError(IecError, ValueError):
    """A value does not fit the type. `type_name`, `expected` and `value` say which and why."""

    def __init__(self, type_name: str, expected: str, value: object) -> None:
        super().__init__(f"{type_name} takes {expected}, got {shown(value)}")
        self.type_name = type_name
        self.expected = expected
        self.value = value


class IecDecodeError(IecError):
    """The bytes are not what the type or table entry prescribes."""


class IecPathError(IecError, LookupError):
    """An instance path cannot be read, or names no part of the type."""


class IecIndexError(IecPathError):
    """The path leads to an array, and an index is outside of its bounds."""


class UnboundError(IecError, RuntimeError):
    """A declared variable was used before its record was bound to memory."""
