"""Symbols of a target: a tree, a search, values as IEC texts, and methods.

Names are those of the PLC; `500:Axes.X.ActPos` is a symbol of the device at another AMS port.
"""

import asyncio
import re
from collections.abc import AsyncIterator, Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import Any, NamedTuple, TypeVar

from achse.ams import AdsError
from achse.client import MethodResult, Target
from achse.iec import (
    ArrayType,
    IecType,
    IecValueError,
    Method,
    PointerType,
    StructType,
    resolved,
)
from achse.iec.documents import as_text
from achse.iec.literals import parse_value
from achse.iec.symbols import SymbolEntry
from achse.web.arguments import Arguments
from achse.web.messages import CallError
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import NC_PORT, PLC_PORT, WatchedTarget

_MOST_LISTED = 1000
_MOST_ELEMENTS = 200
"""Elements of an array that are listed."""

_MOST_LEAVES = 50_000
"""Symbols of one device that a search looks through, members of structures among them."""

_DEEPEST = 6

_SLICE = 200
"""Symbols that are worked on before the station's cycle gets its turn: a millisecond."""

_FARTHEST = 4
"""Distance of a symbol whose comment has a word of the search."""

_T = TypeVar("_T")

_READ_ONLY_FLAG = 0x20

_PORT = re.compile(r"(\d{1,5}):(.+)", re.DOTALL)


class FoundSymbol(NamedTuple):
    """A symbol or a part of one."""

    port: int
    name: str
    type: IecType[Any]
    comment: str
    writable: bool

    @property
    def path(self) -> str:
        """The name with its port, unless it is the PLC's."""
        return self.name if self.port == PLC_PORT else f"{self.port}:{self.name}"

    def row(self) -> dict[str, Any]:
        """As a list shows it."""
        real = resolved(self.type)
        return {
            "name": self.name.rpartition(".")[2],
            "path": self.path,
            "type": self.type.name,
            "size": self.type.size,
            "comment": self.comment,
            "children": isinstance(real, StructType | ArrayType),
            "methods": isinstance(real, StructType) and bool(real.methods),
            "writable": self.writable,
        }

    def parts(self) -> "Iterator[FoundSymbol]":
        """Members of a structure, elements of an array."""
        real = resolved(self.type)
        if isinstance(real, StructType):
            for field in real.fields:
                yield FoundSymbol(
                    self.port, f"{self.name}.{field.name}", field.type, field.comment, self.writable
                )
        elif isinstance(real, ArrayType):
            for number, index in enumerate(_indices(real)):
                if number >= _MOST_ELEMENTS:
                    return
                yield FoundSymbol(
                    self.port, f"{self.name}[{index}]", real.element, "", self.writable
                )


def _indices(array: ArrayType[Any]) -> Iterator[str]:
    """`1,1`, `1,2` …"""
    places = [bounds.first for bounds in array.dimensions]
    for _ in range(array.count):
        yield ",".join(map(str, places))
        for axis in reversed(range(len(places))):
            places[axis] += 1
            if places[axis] <= array.dimensions[axis].last:
                break
            places[axis] = array.dimensions[axis].first


class _Listing:
    """The symbols of one device as they were uploaded; asked for again when they changed."""

    def __init__(self, device: Target) -> None:
        self.device = device
        self._roots: dict[str, FoundSymbol] = {}
        self._leaves: list[tuple[str, FoundSymbol]] | None = None
        self._lock, self._indexing = asyncio.Lock(), asyncio.Lock()
        self._age = -1

    async def roots(self) -> dict[str, FoundSymbol]:
        """Symbols by their names in small letters."""
        async with self._lock:
            age = self.device.session.losses
            if self._age != age:
                self._roots, self._leaves = await self._uploaded(), None
                self._age = age
        return self._roots

    async def _uploaded(self) -> dict[str, FoundSymbol]:
        types = await self.device.types()
        port = self.device.address.port
        symbols: dict[str, FoundSymbol] = {}
        async for entry in _in_slices(await self.device.symbols()):
            symbols[entry.name.lower()] = FoundSymbol(
                port, entry.name, types.symbol_type(entry), entry.comment, _may_be_written(entry)
            )
        return symbols

    def forget(self) -> None:
        """Note that the symbols are others now."""
        self._age = -1

    async def leaves(self) -> list[tuple[str, FoundSymbol]]:
        """Symbols and their parts, not those of arrays, up to a bound; with what a search reads."""
        roots = await self.roots()
        async with self._indexing:
            if self._leaves is None:
                inside = (each for root in roots.values() for each in _within(root, 0))
                leaves = [
                    (f"{each.path} {each.comment}".lower(), each)
                    async for each in _in_slices(islice(inside, _MOST_LEAVES))
                ]
                if roots is not self._roots:
                    return leaves  # they have changed meanwhile
                self._leaves = leaves
            return self._leaves


async def _in_slices(items: Iterable[_T], size: int = _SLICE) -> AsyncIterator[_T]:
    """One after the other; the loop gets its turn after each slice."""
    for number, each in enumerate(items, 1):
        yield each
        if not number % size:
            await asyncio.sleep(0)


def _within(symbol: FoundSymbol, depth: int) -> Iterator[FoundSymbol]:
    yield symbol
    if depth < _DEEPEST and isinstance(resolved(symbol.type), StructType):
        for part in symbol.parts():
            yield from _within(part, depth + 1)


def _distance(path: str, words: Sequence[str]) -> int:
    """Return how far a match is from the words of a search: 0, its path, to `_FARTHEST`.

    The last part of the path counts for more than the parts before it, a comment for least.
    """
    sought, last = words[-1] if words else "", path.rpartition(".")[2]
    if sought in (path, path.partition(":")[2]):
        return 0
    if sought in (last, ".".join(path.split(".")[-1 - sought.count(".") :])):
        return 1
    if last.startswith(sought) or path.startswith(sought):
        return 2
    return 3 if all(word in path for word in words) else _FARTHEST


def _may_be_written(entry: SymbolEntry) -> bool:
    return not entry.flags & _READ_ONLY_FLAG


class SymbolHandlers:
    """Handlers of page calls about symbols."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._watched = watched
        self._listings = {port: _Listing(watched.device(port)) for port in (PLC_PORT, NC_PORT)}
        watched.on_symbols(self._forget)

    def _forget(self) -> None:
        for listing in self._listings.values():
            listing.forget()

    def _where(self, path: str) -> tuple[Target, str]:
        """Device and name of a path."""
        match = _PORT.fullmatch(path)
        if match is None:
            port = NC_PORT if path.lower().startswith("axes.") else PLC_PORT
            return self._watched.device(port), path
        port = int(match[1])
        if not 0 < port < 0x1_0000:
            raise CallError(f"name: expected a port 1..65535, got {path!r:.60}")
        return self._watched.device(port), match[2]

    # looking -----------------------------------------------------------------------------------

    async def listed(self, arguments: Arguments) -> dict[str, Any]:
        """Call `symbols.list`: what is directly below a name, or what a search finds.

        `more` counts what the limit leaves out.
        """
        limit = arguments.integer("limit", 200, 1, _MOST_LISTED)
        search, under = arguments.text("search", "").strip(), arguments.text("under", "").strip()
        if search:
            rows = [each.row() for each in await self.search(search, _MOST_LISTED)]
        else:
            rows = await (self._below(under) if under else self._namespaces())
        return {"rows": rows[:limit], "more": max(len(rows) - limit, 0)}

    async def _below(self, under: str) -> list[dict[str, Any]]:
        device, name = self._where(under)
        listing = self._listings.get(device.address.port)
        if listing is None:
            listing = _Listing(device)
        roots = await listing.roots()
        rows = await _level(roots.values(), name.lower() + ".", name)
        if not rows:
            rows = [part.row() for part in (await self._symbol(device, name, roots)).parts()]
        return rows

    async def _symbol(
        self, device: Target, name: str, roots: dict[str, FoundSymbol]
    ) -> FoundSymbol:
        root = roots.get(name.lower())
        if root is not None:
            return root
        type = await device.type_of(name)
        return FoundSymbol(device.address.port, name, type, "", True)

    async def _namespaces(self) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = []
        for listing in self._listings.values():
            try:
                roots = await listing.roots()
            except AdsError:
                continue  # no device answers, or it has no symbols
            rows += await _level(roots.values(), "", "")
        return rows

    async def search(self, text: str, limit: int) -> list[FoundSymbol]:
        """Return symbols and members whose path or comment has all words of a text.

        The nearest match is first (`_distance`): a limit leaves out the others.
        """
        words = text.lower().split()
        by_distance: list[list[FoundSymbol]] = [[] for _ in range(_FARTHEST + 1)]
        for listing in self._listings.values():
            try:
                leaves = await listing.leaves()
            except AdsError:
                continue
            async for described, each in _in_slices(leaves, 5 * _SLICE):
                if all(word in described for word in words):
                    by_distance[_distance(each.path.lower(), words)].append(each)
        return list(islice(chain.from_iterable(by_distance), limit))

    # values ------------------------------------------------------------------------------------

    async def read(self, arguments: Arguments) -> dict[str, dict[str, str]]:
        """Call `symbols.read`: `text` by name, or `error` for one that cannot be read."""
        return await self._texts(arguments.names("names"))

    async def _texts(self, names: Iterable[str]) -> dict[str, dict[str, str]]:
        by_port: dict[int, dict[str, str]] = {}
        texts: dict[str, dict[str, str]] = {}
        for path in names:
            device, name = self._where(path)
            by_port.setdefault(device.address.port, {})[name] = path
        for port, paths in by_port.items():
            device = self._watched.device(port)
            values = await device.read_many(paths, strict=False)
            for name, value in values.items():
                if isinstance(value, AdsError):
                    texts[paths[name]] = {"error": str(value)}
                else:
                    texts[paths[name]] = {"text": as_text(await device.type_of(name), value)}
        return texts

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `symbols`: values of names as texts."""
        every = arguments.number("every", 0.2, 0.02, 10.0)
        names = arguments.names("names", 500)
        while True:
            subscription.show(await self._texts(names))
            await subscription.pause(every)

    async def write(self, arguments: Arguments) -> dict[str, Any]:
        """Call `symbols.write`: set a symbol to an IEC literal; the answer is its value."""
        device, name = self._where(arguments.text("name"))
        value = arguments.value("value")
        type = await device.type_of(name)
        text = _literal(value)
        try:
            await device.write(name, parse_value(type, text))
        except IecValueError as fault:
            raise CallError(f"value: {fault}") from None
        return {"value": as_text(type, await device.read(name))}

    async def call(self, arguments: Arguments) -> dict[str, Any]:
        """Call `symbols.call`: `MAIN.fbMotor.Start` or `MAIN.fbMotor#Start`, with its inputs."""
        device, path = self._where(arguments.text("name"))
        block, mark, method = path.rpartition("#" if "#" in path else ".")
        if not mark:
            raise CallError(f"name: expected BLOCK.METHOD, got {path!r:.60}")
        inputs = arguments.fields.get("arguments", {})
        if not isinstance(inputs, dict):
            raise CallError(f"arguments: expected an object, got {inputs!r:.60}")
        types = {
            each.name: each.type
            for declared in await self._methods(device, block)
            if declared.name.lower() == method.lower()
            for each in declared.inputs
        }
        inputs = {
            name: parse_value(types[name], value)
            if name in types and isinstance(value, str)
            else value
            for name, value in inputs.items()
        }
        answer = await device.call(block, method, **inputs)
        if isinstance(answer, MethodResult):
            outputs = {name: _plain(value) for name, value in answer.outputs.items()}
            return {"result": _plain(answer.value), "outputs": outputs}
        return {"result": _plain(answer), "outputs": {}}

    async def methods(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `symbols.methods`: those of a function block, with their parameters."""
        device, name = self._where(arguments.text("name"))
        return [
            {
                "name": method.name,
                "returns": "" if method.returns is None else method.returns.name,
                "parameters": [
                    {"name": each.name, "type": each.type.name, "direction": way, "comment": ""}
                    for way, part in (("in", method.inputs), ("out", method.outputs))
                    for each in part
                ],
            }
            for method in await self._methods(device, name)
        ]

    async def _methods(self, device: Target, name: str) -> Sequence[Method]:
        real = resolved(await device.type_of(name))
        while isinstance(real, PointerType):
            real = resolved(real.target)
        return real.methods if isinstance(real, StructType) else ()


async def _level(symbols: Iterable[FoundSymbol], inside: str, under: str) -> list[dict[str, Any]]:
    """Rows of one level of the tree: symbols, and names that others begin with."""
    rows: dict[str, dict[str, Any]] = {}
    cut = len(inside)
    async for each in _in_slices(symbols):
        if not each.name.lower().startswith(inside):
            continue
        head, dot, _ = each.name[cut:].partition(".")
        name = f"{under}.{head}" if under else head
        if not dot:
            rows[name.lower()] = each.row()
        elif name.lower() not in rows:
            rows[name.lower()] = {
                "name": head, "path": each._replace(name=name).path, "type": "", "size": 0,
                "comment": "", "children": True, "methods": False, "writable": False,
            }  # fmt: skip
    return list(rows.values())


def _literal(value: Any) -> str:
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, int | float):
        return repr(value)
    if not isinstance(value, str):
        raise CallError(f"value: expected a text with an IEC literal, got {value!r:.60}")
    return value


def _plain(value: Any) -> Any:
    return value if isinstance(value, bool | int | float | str) or value is None else str(value)
