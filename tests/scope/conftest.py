"""Recordings and memory that the tests of the scope share."""

from array import array
from collections.abc import Callable

import pytest

from achse.native.backend import compiler_installed
from achse.native.memory import MemoryCell
from achse.scope import (
    SCOPE_TYPES,
    ScopeBlock,
    ScopeChannel,
    ScopeData,
    ScopeError,
    ScopeSource,
)

MS = 1_000_000
BEGIN_NS = 1_767_225_600_000_000_000

Bind = Callable[[ScopeChannel], ScopeSource]


@pytest.fixture(params=[True, False], ids=["compiled", "plain"])
def compiled(request: pytest.FixtureRequest) -> bool:
    """Both ways of sampling."""
    if request.param and not compiler_installed():
        pytest.skip("no compiler")
    return bool(request.param)


def recording() -> ScopeData:
    """Every type at 2 ms, with a channel that ends early, and a scaled one at 4 ms."""
    channels, types = [], []
    for name, type in SCOPE_TYPES.items():
        channels.append(ScopeChannel(f"GVL.{name}", symbol=f"GVL.{name}", port=851))
        types.append(type)
    rows = array("q")
    for n in range(6):
        for type in types:
            number: float = {"b": n - 3, "h": -n, "i": -(n << 20), "q": -(n << 40)}.get(
                type.code, n
            )
            if type.real:
                number = (-1) ** n * 10.0 ** (7 * n - 10)
            rows.append(type.word(bool(n % 2) if type.code == "?" else number))
    count = len(channels)
    first = ScopeBlock(
        BEGIN_NS, 2 * MS, tuple(channels), tuple(types), (6,) * (count - 1) + (4,), rows.tobytes()
    )
    scaled = ScopeChannel(
        "level", "", 0x4020, 8, 851, "INT16", scale=0.5, offset=-1.0, unit="mm", comment="a\tb"
    )
    slow = array("q", [SCOPE_TYPES["INT16"].word(n - 1) for n in range(3)])
    second = ScopeBlock(
        BEGIN_NS + MS, 4 * MS, (scaled,), (SCOPE_TYPES["INT16"],), (3,), slow.tobytes()
    )
    return ScopeData("press 1", (first, second), BEGIN_NS + 4 * MS)


@pytest.fixture
def memory() -> bytearray:
    """128 bytes in which channels find their values."""
    return bytearray(128)


@pytest.fixture
def bind(memory: bytearray) -> Bind:
    """Channels `TYPE.OFFSET` of the memory, every ms."""

    def find(channel: ScopeChannel) -> ScopeSource:
        name, _, offset = channel.symbol.partition(".")
        if name not in SCOPE_TYPES:
            raise ScopeError(f"{channel.name}: no symbol {channel.symbol}")
        type = SCOPE_TYPES[name]
        return ScopeSource(MemoryCell(memory, int(offset), type.size), type, MS)

    return find
