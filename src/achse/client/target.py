"""One ADS device as a client sees it: values by name, by place with a type, and subscriptions."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar, overload

from achse.ams import (
    AdsError,
    AmsAddress,
    DecodeError,
    DeviceError,
    NetId,
    RequestTimeout,
    TransmissionMode,
)
from achse.ams.commands import ReadRequest, WriteRequest
from achse.client.session.raw import STALE, RawTarget
from achse.client.session.session import Session
from achse.client.session.subscription import Subscription, Timing, VariableLocation
from achse.client.session.sums import Outcome
from achse.client.session.symbols import SymbolBook
from achse.codes import ReservedGroup, ReturnCode
from achse.iec import (
    IecDecodeError,
    IecPathError,
    IecType,
    IecValueError,
    Method,
    PointerType,
    StructType,
    Typelike,
    iec_type,
    resolved,
)
from achse.iec.derived import OpaqueType
from achse.iec.nearest import did_you_mean
from achse.iec.symbols import SymbolEntry
from achse.iec.typetable import TypeTable

if TYPE_CHECKING:
    from achse.client.nc.controller import RemoteNc
    from achse.client.scope import Channels, RemoteScope, Triggers

V = TypeVar("V")

NC_PORT = 500
"""AMS port of the NC (002 §6.4)."""

SendWhen = Literal["change", "cycle"] | TransmissionMode
"""Condition on which a subscription sends: a change of the value, or each cycle."""


def transmission_mode(send: SendWhen) -> TransmissionMode:
    """Return the mode that a word names."""
    if send == "change":
        return TransmissionMode.SERVER_ON_CHANGE
    if send == "cycle":
        return TransmissionMode.SERVER_CYCLE
    try:
        return TransmissionMode(send)
    except ValueError:
        raise ValueError(f"mode: expected 'change' or 'cycle', got {send!r:.80}") from None


class MethodResult(NamedTuple):
    """Result of a method with outputs."""

    value: Any
    """The return value, None if it has none."""
    outputs: Mapping[str, Any]
    """The outputs by name."""


class Target(RawTarget):
    """A device behind an AMS port.

    Values by name have the type the device itself declares: its symbol and type entries are
    fetched when first needed and kept until the device says that they changed. Everything may be
    used by any number of tasks at once, and every request may be cancelled.

    Raises, all `AdsError`: `DeviceError` (the device refused), `RouterError` (no device is there),
    `RequestTimeout`, `ConnectionLost`; `IecValueError` for a value that does not fit the type.
    """

    def __init__(
        self,
        session: Session,
        address: AmsAddress,
        timeout: float,
        books: dict[AmsAddress, SymbolBook],
        watch_symbols: bool = True,
    ) -> None:
        super().__init__(session, address, timeout)
        self._books = books
        self._watch_symbols = watch_symbols
        book = books.get(address)
        if book is None:
            device = RawTarget(session, address, session.timeout)
            book = books[address] = SymbolBook(device, watch_symbols)
        self._book = book
        self._nc: RemoteNc | None = None

    def at_port(self, port: int, net_id: str | NetId | None = None) -> "Target":
        """Another device, over the same connection."""
        where = self.address.net_id if net_id is None else NetId(net_id)
        address = AmsAddress.of(where, port)
        return Target(self.session, address, self.timeout, self._books, self._watch_symbols)

    def within(self, seconds: float) -> "Target":
        """Return the same device, with another time limit for each request."""
        return Target(self.session, self.address, seconds, self._books, self._watch_symbols)

    @property
    def nc(self) -> "RemoteNc":
        """The NC beside this device, at port 500: `target.nc.axis("X")`."""
        from achse.client.nc.controller import RemoteNc  # is made of targets

        if self._nc is None:
            self._nc = RemoteNc(self if self.address.port == NC_PORT else self.at_port(NC_PORT))
        return self._nc

    def scope(
        self,
        channels: "Channels",
        *,
        length: float = 10.0,
        triggers: "Triggers" = (),
        pretrigger: float = 0.0,
        combine: str = "any",
        name: str = "client",
    ) -> "RemoteScope":
        """Return a scope at the achse station behind this target, which samples in its cycle.

        `async with target.scope(["MAIN.fLevel"], length=2.0) as scope:` makes and starts it.
        Channels without port are of this device. `length` in seconds is what its rings hold,
        `pretrigger` the share of it before the trigger. Raises ScopeError.
        """
        from achse.client.scope import defined, scope_of  # loaded when scopes are used

        definition = defined(
            channels,
            port=self.address.port,
            length=length,
            triggers=triggers,
            pretrigger=pretrigger,
            combine=combine,
            name=name,
        )
        return scope_of(self, definition)

    # by name -----------------------------------------------------------------------------------

    async def read(self, name: str) -> Any:
        """Return the value of symbol `name`: number, text, time, enum member, record, list."""

        async def read(place: VariableLocation) -> Any:
            return place.value(await self.read_raw(place.group, place.offset, place.length))

        return await self._at(name, "read", read)

    async def write(self, name: str, value: object) -> None:
        """Set symbol `name`; IecValueError if `value` is none of its type."""

        async def write(place: VariableLocation) -> None:
            await self.write_raw(place.group, place.offset, _encoded(place, value))

        await self._at(name, "write", write)

    async def _at(self, name: str, verb: str, act: Callable[[VariableLocation], Awaitable[V]]) -> V:
        """Do `act` at the place of `name`; repeat it if the place has changed."""
        place = self._book.known(name)
        if place is None:
            place = await self._soon(self._book.place(name))
        try:
            try:
                return await act(place)
            except DeviceError as error:
                if error.code not in STALE:
                    raise
                self._book.forget(place)
            return await act(await self._soon(self._book.place(name)))
        except DeviceError as error:
            raise DeviceError(error.code, f"{verb} {name}") from error

    async def _soon(self, looking: Coroutine[Any, Any, V]) -> V:
        """Return the result of looking symbols up, within the time limit; others may wait
        longer."""
        if self.timeout >= self.session.timeout:
            return await looking
        try:
            async with asyncio.timeout(self.timeout):
                return await looking
        except TimeoutError:
            raise RequestTimeout(f"look symbols up in {self.address}") from None

    @overload
    async def read_many(self, names: Iterable[str]) -> dict[str, Any]: ...
    @overload
    async def read_many(
        self, names: Iterable[str], *, strict: bool
    ) -> dict[str, Any | AdsError]: ...
    async def read_many(self, names: Iterable[str], *, strict: bool = True) -> dict[str, Any]:
        """Return the values of many symbols, in sum commands of at most 500, by name.

        A symbol that fails raises its error; with `strict` False it is in the result instead.
        """
        if isinstance(names, str):
            raise TypeError(f"a list of names expected, got the text {names[:80]!r}: [{names!r}]?")
        if not isinstance(names, Iterable):
            raise TypeError(f"a list of names expected, got {names!r:.80}")
        wanted = list(dict.fromkeys(names))
        outcomes = await self._each(
            "read", wanted, lambda place: ReadRequest(place.group, place.offset, place.length)
        )
        values: dict[str, Any] = {}
        for name, (place, outcome) in zip(wanted, outcomes, strict=True):
            if isinstance(outcome, AdsError):
                if strict:
                    raise outcome
                values[name] = outcome
            else:
                assert place is not None
                values[name] = place.value(outcome.data)
        return values

    async def write_many(
        self, values: Mapping[str, object], *, strict: bool = True
    ) -> dict[str, AdsError]:
        """Set many symbols, in sum commands of at most 500.

        IecValueError for a value that is none of its type, before anything is written. Otherwise
        all that can be written are, whatever happens to others. A symbol that fails raises its
        error afterwards; with `strict` False the errors are returned by name.
        """
        if not isinstance(values, Mapping):
            raise TypeError(f"a mapping of names to values expected, got {values!r:.80}")
        outcomes = await self._each(
            "write",
            list(values),
            lambda place: WriteRequest(
                place.group, place.offset, _encoded(place, values[place.name])
            ),
        )
        errors = {
            name: outcome
            for name, (_, outcome) in zip(values, outcomes, strict=True)
            if isinstance(outcome, AdsError)
        }
        if strict:
            for error in errors.values():
                raise error
        return errors

    async def _each(
        self,
        verb: str,
        names: Sequence[str],
        part: Callable[[VariableLocation], ReadRequest]
        | Callable[[VariableLocation], WriteRequest],
    ) -> list[tuple[VariableLocation | None, Outcome | AdsError]]:
        """Send `part` for each symbol; those whose handle is out of date are tried once more."""
        outcomes = await self._try_each(verb, names, part)
        again = [
            index
            for index, (place, outcome) in enumerate(outcomes)
            if place is not None and isinstance(outcome, DeviceError) and outcome.code in STALE
        ]
        for index in again:
            place = outcomes[index][0]
            assert place is not None
            self._book.forget(place)
        if again:
            second = await self._try_each(verb, [names[index] for index in again], part)
            for index, result in zip(again, second, strict=True):
                outcomes[index] = result
        return outcomes

    async def _try_each(
        self,
        verb: str,
        names: Sequence[str],
        part: Callable[[VariableLocation], ReadRequest]
        | Callable[[VariableLocation], WriteRequest],
    ) -> list[tuple[VariableLocation | None, Outcome | AdsError]]:
        places = await self._soon(self._book.places(names))
        locations = [place for place in places if isinstance(place, VariableLocation)]
        outcomes = iter(await self.send_each([part(place) for place in locations]))
        results: list[tuple[VariableLocation | None, Outcome | AdsError]] = []
        for name, place in zip(names, places, strict=True):
            if not isinstance(place, VariableLocation):
                results.append((None, place))
                continue
            outcome = next(outcomes)
            if outcome.result:
                results.append((place, DeviceError(outcome.result, f"{verb} {name}")))
            else:
                results.append((place, outcome))
        return results

    async def symbols(self) -> list[SymbolEntry]:
        """Return every symbol the device lists: name, type, place, size, comment, attributes."""
        return await self._book.entries()

    async def type_of(self, name: str) -> IecType[Any]:
        """Return the type of symbol `name`, as the device declares it."""
        return (await self._soon(self._book.place(name))).type

    async def types(self) -> TypeTable:
        """Return the types the device declares; empty if it has no tables."""
        return await self._book.all_types()

    async def call(self, name: str, method: str | Method, /, **inputs: object) -> Any:
        """Call a method of the function block `name`: `await plc.call("MAIN.fb", "Add", nA=1)`.

        The answer is the return value (None without one); of a method with outputs a
        `MethodResult` with both. Inputs and answer have the types the device declares; for a
        device that declares none, give a `Method`. Raises `IecValueError` for inputs that do not
        fit, `DeviceError` 0x710 if there is no such method.
        """
        declared = method if isinstance(method, Method) else await self._method(name, method)
        data = declared.encode_inputs(inputs)
        path = f"{name}#{declared.name}"
        try:
            try:
                answer = await self._call(path, declared, data)
            except DeviceError as error:
                if error.code not in STALE:
                    raise
                self._book.forget_method(path)
                answer = await self._call(path, declared, data)
            results = declared.decode_answer(answer)
        except DeviceError as error:
            raise DeviceError(error.code, f"call {path}") from error
        except IecDecodeError as error:
            raise DecodeError(f"call {path}: {error}") from error
        value = None if declared.returns is None else results[0]
        if not declared.outputs:
            return value
        values = results[len(results) - len(declared.outputs) :]
        names = [output.name for output in declared.outputs]
        return MethodResult(value, dict(zip(names, values, strict=True)))

    async def _call(self, path: str, method: Method, data: bytes) -> bytes:
        handle = await self._soon(self._book.method_handle(path))
        return await self.read_write_raw(
            ReservedGroup.SYMBOL_VALUE_BY_HANDLE, handle, method.answer_size, data
        )

    async def _method(self, name: str, method: str) -> Method:
        type = resolved(await self.type_of(name))
        while isinstance(type, PointerType):
            type = resolved(type.target)
        refusal = DeviceError(
            ReturnCode.SYMBOL_NOT_FOUND, f"{name} : {type.name} declares no method {method}"
        )
        if isinstance(type, StructType):
            try:
                return type.method(method)
            except IecPathError:
                refusal.hint = did_you_mean(method, [one.name for one in type.methods])
        raise refusal

    # by place ----------------------------------------------------------------------------------

    async def read_as(self, group: int, offset: int, type: Typelike) -> Any:
        """Return a value of `type` (`LREAL`, `ARRAY(INT, (0, 3))`, a `Struct` class …) at a
        place."""
        place = _place(group, offset, iec_type(type))
        return place.value(await self.read_raw(group, offset, place.length))

    async def write_as(self, group: int, offset: int, type: Typelike, value: object) -> None:
        """Write `value` as `type` to a place."""
        await self.write_raw(group, offset, iec_type(type).encode(value))

    # subscriptions -----------------------------------------------------------------------------

    def subscribe(
        self,
        names: str | Iterable[str],
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> Subscription:
        """Samples of one symbol or of many, all in one queue.

        `async with target.subscribe(…) as samples: async for sample in samples: …`. Times in
        seconds: the device looks each `cycle_time`, and may gather samples for `max_delay`.
        `depth` samples wait for you; beyond that the oldest are dropped and counted.
        """
        wanted = [names] if isinstance(names, str) else list(names)
        if not wanted:
            raise ValueError("a subscription has at least one symbol")
        timing = Timing.of(transmission_mode(mode), max_delay, cycle_time)
        return Subscription(
            self, lambda: self._book.locate(wanted), timing, depth, self._book.forget
        )

    def subscribe_as(
        self,
        group: int,
        offset: int,
        type: Typelike | int,
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> Subscription:
        """Samples of a place, as `type` or, if that is a length, as so many bytes."""
        as_type = OpaqueType("bytes", type, 1, 0) if isinstance(type, int) else iec_type(type)
        place = _place(group, offset, as_type)

        async def locate() -> Sequence[VariableLocation]:
            return [place]

        timing = Timing.of(transmission_mode(mode), max_delay, cycle_time)
        return Subscription(self, locate, timing, depth)


def _place(group: int, offset: int, type: IecType[Any]) -> VariableLocation:
    return VariableLocation(f"0x{group:X}:0x{offset:X}", group, offset, type.size, type)


def _encoded(place: VariableLocation, value: object) -> bytes:
    try:
        return place.type.encode(value)
    except IecValueError as error:
        error.add_note(f"symbol {place.name}")
        raise
