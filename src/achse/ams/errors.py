"""The error tree of the wire.

AdsError
├── DecodeError      bytes from the peer are not AMS; the connection cannot go on
├── RouterError      a router refused the frame: code in the AMS header
├── DeviceError      a device refused the request: code in the result field
├── ConnectionLost   the transport ended while an answer was due
└── RequestTimeout   no answer in time (0x745)
"""

from achse.codes import ReturnCode, code_of


def describe_code(code: int) -> str:
    """`0x710 SYMBOL_NOT_FOUND: Symbol not found.`, or the bare number where no table names it.

    NC errors are described alike.
    """
    row = code_of(code)
    return f"0x{code:X}" if row is None else f"0x{code:X} {row.name}: {row.text}"


class AdsError(Exception):
    """Anything that goes wrong between an ADS client and an ADS device."""


class DecodeError(AdsError):
    """The bytes are not what AMS prescribes; says what was expected and what came."""


class CodedError(AdsError):
    """An error that carries the number which travelled.

    `context` says which request failed, for people, and `hint` what may help: text that ends the
    message, like `; did you mean 'MAIN.nCounter'?`. Neither travels.
    """

    hint = ""

    def __init__(self, code: "int | ReturnCode", context: str = "") -> None:
        self.code = int(code)
        self.context = context
        super().__init__(self.code, context)

    @property
    def return_code(self) -> ReturnCode | None:
        """The table row of the code, None if it is an NC code or unknown."""
        return ReturnCode.of(self.code)

    def __str__(self) -> str:
        text = describe_code(self.code)
        if self.hint:
            text = f"{text.rstrip('.')}{self.hint}"
        return f"{self.context}: {text}" if self.context else text


class RouterError(CodedError):
    """A router answered with an error in the AMS header; the frame reached no device."""


class DeviceError(CodedError):
    """A device answered with an error result. A server raises the same to give that answer."""


class ConnectionLost(AdsError):
    """The transport ended; requests under way get no answer."""


class RequestTimeout(CodedError):
    """No answer came within the time limit (0x745)."""

    def __init__(self, context: str = "") -> None:
        super().__init__(ReturnCode.CLIENT_TIMEOUT, context)
        self.args = (context,)  # what a copy or a pickle is made from
