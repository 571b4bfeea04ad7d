"""Taps of a router as a service: clients open them, fetch what has passed, and close them."""

from collections.abc import Callable

from achse.ams import DeviceError, Endpoint, RouterError
from achse.codes import ReturnCode
from achse.router.tap import Tap, Taps, encode_batch
from achse.server import RawGroup

TAPS = 0xFA02
"""Index group."""

_PER_CLIENT = 4


class TapService:
    """The open taps of clients; `taps` are those of their router, for all clients together.

    `way()` is the connection of the request that is being answered.
    """

    def __init__(self, taps: Taps, way: Callable[[], Endpoint | None]) -> None:
        self._all = taps
        self._way = way
        self._open: dict[int, tuple[bytes, Endpoint | None, Tap]] = {}
        self._last = 0
        self.group = RawGroup(
            TAPS,
            "taps",
            read=self._take,
            read_write=self._begin,
            write=self._end,
            last_offset=0xFFFF_FFFF,
            response="UINT32 tap; captures: UINT64 Unix ns, BYTE inwards, BYTE n, UINT32 m,"
            " BYTE[n] peer, BYTE[m] AMS packet",
            description="ReadWrite opens a tap; offset = tap: Read fetches what has passed,"
            " Write closes it.",
            source="achse",
        )
        """The service for a device."""

    @property
    def clients(self) -> set[bytes]:
        """Clients with open taps."""
        return {owner for owner, _, _ in self._open.values()}

    def _begin(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        if sum(owner == client for owner, _, _ in self._open.values()) >= _PER_CLIENT:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"{_PER_CLIENT} taps are open")
        try:
            tap = self._all.open()
        except RouterError as refusal:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, refusal.context) from None
        self._last += 1
        self._open[self._last] = (client, self._way(), tap)
        return self._last.to_bytes(4, "little")

    def _tap(self, number: int, client: bytes) -> Tap:
        owner, _, tap = self._open.get(number, (None, None, None))
        if tap is None or owner != client:
            raise DeviceError(ReturnCode.NOT_FOUND, f"tap {number}")
        return tap

    def _take(self, number: int, length: int, client: bytes) -> bytes:
        return encode_batch(self._tap(number, client).take(length))

    def _end(self, number: int, data: bytes, client: bytes) -> None:
        self._tap(number, client).close()
        del self._open[number]

    def end_client(self, client: bytes) -> None:
        """Close what a client left open."""
        self._close_where(lambda owner, way: owner == client)

    def end_way(self, way: Endpoint) -> None:
        """Close what was opened over a connection that is gone."""
        self._close_where(lambda owner, opened_by: opened_by is way)

    def _close_where(self, gone: Callable[[bytes, Endpoint | None], bool]) -> None:
        for number, (owner, opened_by, tap) in list(self._open.items()):
            if gone(owner, opened_by):
                tap.close()
                del self._open[number]
