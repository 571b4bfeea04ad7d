"""Value handles: the numbers by which clients reach symbols (index groups 0xF003 … 0xF006).

Source: 000 §5.3.2, 002 §6.3, 003. Handles outlive the connection that requested them: the test
script of the vendor's command line tool requests a handle in one process and uses it in the next.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Generic, TypeVar
from weakref import WeakValueDictionary

from achse.ams import DeviceError, Endpoint
from achse.codes import ReturnCode
from achse.server.limits import ClientLimits
from achse.server.table import Reader
from achse.server.usage import Usage, host_of

Symbol = TypeVar("Symbol")

_TIME_SHIFT = 14
"""Bits of the station's time (ns) below the first number, which so rises by 61,035 a second.

That is more than clients request on average, so a later table begins beyond the numbers of an
earlier one; after 19.5 h the numbers come again.
"""

_ENDED_AT_ONCE = 10_000
"""Abandoned handles that end in one go at most."""


class HandleOwner:
    """One client over one connection, with the numbers of the handles that it requested."""

    __slots__ = ("_end", "abandoned", "client", "host", "numbers", "way")

    def __init__(self, table: "HandleTable[Symbol]", client: bytes, way: Endpoint | None) -> None:
        self._end = table.end
        self.client = client
        self.way = way
        self.host = host_of(way)
        self.numbers: set[int] = set()
        self.abandoned = False
        """True after the connection has ended; `way` is None then."""

    def end_one(self) -> None:
        """End one of the handles."""
        self._end(self.numbers.pop())


class Handle(Generic[Symbol]):
    """A symbol by its number; `read` returns its value."""

    __slots__ = ("owner", "read", "symbol")

    def __init__(self, symbol: Symbol, read: Reader, owner: HandleOwner) -> None:
        self.symbol = symbol
        self.read = read
        self.owner = owner


class HandleTable(Generic[Symbol]):
    """The handles of one device.

    Handles are opaque and not zero, in a number space of their own. Every client may use each of
    them. A handle counts for the client that requested it until the connection of that request
    ends. Then it is abandoned: it stays valid, but is the first to end when a limit is reached.
    A client may release its own handles and abandoned ones, and all that it has abandoned at once.
    After a change of the symbol table the old handles answer 0x711 until released; an unknown
    handle answers 0x710, its release 0x711.

    The first number comes from `clock`, the station's time, unix ns: a handle from before a restart
    is unknown after it.
    """

    def __init__(self, limits: ClientLimits, clock: Callable[[], int]) -> None:
        self.limits = limits
        self.usage = Usage(limits)
        self.refused = 0
        """Requests for a handle that were refused because of the limits."""
        self._valid: dict[int, Handle[Symbol]] = {}
        self.valid: Mapping[int, Handle[Symbol]] = self._valid
        """Handles of the present symbol table, by number."""
        self.symbols: WeakValueDictionary[str, Symbol] = WeakValueDictionary()
        """Symbols of valid handles by name: all handles of one name share the symbol."""
        self._stale: dict[int, HandleOwner] = {}
        """Owners of the handles that are out of date, by number."""
        self._owners: dict[bytes, dict[Endpoint | None, HandleOwner]] = {}
        self._counts: dict[bytes, int] = {}
        """Handles that count for each client, over all its connections."""
        self._clients_by_way: dict[Endpoint, set[bytes]] = {}
        self._abandoned: dict[bytes, set[HandleOwner]] = {}
        """Owners of abandoned handles, by client."""
        self._clock = clock
        self._next = 0
        """Number to try for the next handle; 0 before the first one."""

    def __len__(self) -> int:
        """Return all handles: valid, out of date and abandoned ones."""
        return len(self._valid) + len(self._stale)

    @property
    def clients(self) -> Iterable[bytes]:
        """The addresses for which handles count."""
        return self._owners.keys()

    def count_of(self, net_id: bytes) -> int:
        """Return how many handles clients with this NetId have requested, abandoned ones too."""
        return sum(owner.client[:6] == net_id for _, owner in self._by_owner())

    def find(self, number: int) -> Handle[Symbol]:
        """Return a valid handle; raises DeviceError 0x711 if it is out of date, else 0x710."""
        handle = self._valid.get(number)
        if handle is None:
            code = ReturnCode.SYMBOL_NOT_FOUND
            if number in self._stale:
                code = ReturnCode.SYMBOL_VERSION_INVALID
            raise DeviceError(code, f"handle 0x{number:X}")
        return handle

    def add(self, symbol: Symbol, read: Reader, client: bytes, way: Endpoint | None) -> int:
        """Return a new handle that counts for `client`; raises DeviceError 0x716 at a limit."""
        own = self._make_room(client, way)
        number = self._next or _number_at(self._clock())
        while number in self._valid or number in self._stale:
            number = _following(number)
        self._next = _following(number)
        ways = self._owners.setdefault(client, {})
        owner = ways.get(way)
        if owner is None:
            owner = ways[way] = HandleOwner(self, client, way)
            if way is not None:
                self._clients_by_way.setdefault(way, set()).add(client)
        owner.numbers.add(number)
        self._counts[client] = own + 1
        self._valid[number] = Handle(symbol, read, owner)
        self.usage.handles += 1
        self.usage.handles_by_host.add(owner.host, 1)
        return number

    def _make_room(self, client: bytes, way: Endpoint | None) -> int:
        """Return how many handles count for `client`; raises DeviceError 0x716 at a limit."""
        own = self._counts.get(client, 0)
        usage, limits = self.usage, self.limits
        if own < limits.handles and usage.handles >= limits.all_handles:
            usage.end_abandoned(1)
        host, by_host = host_of(way), usage.handles_by_host
        is_full = usage.handles >= limits.all_handles
        if is_full or own >= limits.handles or by_host.is_full(host, limits.all_handles):
            self.refused += 1
            raise DeviceError(
                ReturnCode.NO_MORE_HANDLES,
                f"handles: {own} of the client, {by_host[host]} of its host,"
                f" {usage.handles} of all",
            )
        return own

    def release(self, number: int, client: bytes) -> None:
        """End a handle of `client` or an abandoned one; raises DeviceError 0x711."""
        handle = self._valid.get(number)
        owner = self._stale.get(number) if handle is None else handle.owner
        if owner is None:
            raise DeviceError(ReturnCode.SYMBOL_VERSION_INVALID, f"handle 0x{number:X}")
        if owner.client != client and not owner.abandoned:
            raise DeviceError(
                ReturnCode.SYMBOL_VERSION_INVALID, f"handle 0x{number:X} of another client"
            )
        self.end(number)

    def release_abandoned(self, client: bytes) -> None:
        """End all handles that this client has abandoned."""
        for owner in list(self._abandoned.get(client, ())):
            while owner.numbers:
                owner.end_one()

    def end(self, number: int) -> None:
        """End a handle of any client."""
        handle = self._valid.pop(number, None)
        owner = self._stale.pop(number) if handle is None else handle.owner
        owner.numbers.discard(number)
        usage = self.usage
        usage.handles -= 1
        if owner.abandoned:
            usage.abandoned_handles -= 1
            if not owner.numbers:
                self._forget_abandoned(owner)
        else:
            self._counts[owner.client] -= 1
            usage.handles_by_host.add(owner.host, -1)
            if not owner.numbers:
                self._remove(owner)

    def _remove(self, owner: HandleOwner) -> None:
        """Let nothing count for an owner any more."""
        ways = self._owners[owner.client]
        del ways[owner.way]
        self._counts[owner.client] -= len(owner.numbers)
        self.usage.handles_by_host.add(owner.host, -len(owner.numbers))
        if not ways:
            del self._owners[owner.client], self._counts[owner.client]
        if owner.way is not None:
            clients = self._clients_by_way[owner.way]
            clients.remove(owner.client)
            if not clients:
                del self._clients_by_way[owner.way]

    def _abandon(self, owner: HandleOwner) -> None:
        self._remove(owner)
        owner.abandoned, owner.way = True, None
        self.usage.abandoned[owner] = None
        self.usage.abandoned_handles += len(owner.numbers)
        self._abandoned.setdefault(owner.client, set()).add(owner)

    def _forget_abandoned(self, owner: HandleOwner) -> None:
        """Forget the owner, if none of its abandoned handles is left."""
        del self.usage.abandoned[owner]
        owners = self._abandoned[owner.client]
        owners.remove(owner)
        if not owners:
            del self._abandoned[owner.client]

    def abandon_client(self, client: bytes) -> None:
        """Abandon the handles of a client that is gone."""
        owners = self._owners.get(client)
        if owners is not None:
            for owner in list(owners.values()):
                self._abandon(owner)
            self.clear()

    def abandon_way(self, way: Endpoint) -> None:
        """Abandon the handles that were requested over a connection that has ended."""
        clients = self._clients_by_way.get(way)
        if clients is not None:
            for client in list(clients):
                self._abandon(self._owners[client][way])
            self.clear()

    def clear(self) -> None:
        """End some of the abandoned handles beyond their limit; called about once a second.

        Ending many of them at once would hold up the station.
        """
        excess = self.usage.abandoned_handles - self.limits.abandoned_handles
        if excess > 0:
            self.usage.end_abandoned(min(excess, _ENDED_AT_ONCE))

    def invalidate(self) -> None:
        """Put every handle out of date: the symbol table has changed."""
        self._stale.update((number, handle.owner) for number, handle in self._valid.items())
        self._valid.clear()
        self.symbols.clear()

    def _by_owner(self) -> Iterator[tuple[int, HandleOwner]]:
        """Return number and owner of each handle."""
        yield from ((number, handle.owner) for number, handle in self._valid.items())
        yield from self._stale.items()

    def end_abandoned(self) -> None:
        """End all abandoned handles of this device."""
        for number in [each for each, owner in self._by_owner() if owner.abandoned]:
            self.end(number)

    def end_all(self) -> None:
        """End all handles: the device is gone."""
        usage = self.usage
        usage.handles -= len(self)
        for owner in {owner for _, owner in self._by_owner()}:
            if owner.abandoned:
                usage.abandoned_handles -= len(owner.numbers)
                del usage.abandoned[owner]
            else:
                usage.handles_by_host.add(owner.host, -len(owner.numbers))
        self._valid.clear()
        self.symbols.clear()
        self._stale.clear()
        self._owners.clear()
        self._counts.clear()
        self._clients_by_way.clear()
        self._abandoned.clear()


def _number_at(unix_ns: int) -> int:
    """Return the number with which the handles of a table begin that is first used at `unix_ns`."""
    return unix_ns >> _TIME_SHIFT & 0xFFFF_FFFF or 1


def _following(number: int) -> int:
    """Return the next number of a handle; after 0xFFFFFFFF comes 1."""
    return number + 1 & 0xFFFF_FFFF or 1
