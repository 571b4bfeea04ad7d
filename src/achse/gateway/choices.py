"""Choices of clients of a gateway for their connections, sent to port 1."""

from collections.abc import Callable

from achse.ams import DeviceError, Endpoint
from achse.codes import ReturnCode
from achse.router.forwarding.resubscription import Resubscription
from achse.server import RawGroup

RESUBSCRIBE = 3
"""Index group of the choice at port 1."""


def resubscribe_group(choices: Resubscription, way: Callable[[], Endpoint | None]) -> RawGroup:
    """Return the index group in which a client chooses; `way()` is the connection of its request.

    A client sends 1 byte by ReadWrite, other than 0 if its subscriptions and symbol handles are to
    be made again when the lost connection to a target is back. It applies to what it fetches from
    now on.
    """

    def choose(offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        if len(data) != 1:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"resubscribe: expected 1 byte, got {len(data)}"
            )
        connection = way()
        if connection is None:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "resubscribe: no connection")
        choices.choose(connection, bool(data[0]))
        return bytes([bool(data[0])])

    return RawGroup(
        RESUBSCRIBE,
        "resubscribe",
        read_write=choose,
        request="BOOL",
        response="BOOL",
        description="Subscriptions and symbol handles of this connection are made again when a lost"
        " connection to a target is back.",
        source="achse",
    )
