"""Scopes of a station without asyncio: the names of `achse.client.scope`, and they wait."""

from types import TracebackType
from typing import Any, Self

from achse.client.loop import LoopThread
from achse.client.scope import RemoteScope
from achse.scope.data import ScopeData

__all__ = ["BlockingScope"]


class BlockingScope:
    """One scope of a station; see `achse.client.scope.RemoteScope`, whose methods these are."""

    def __init__(self, loop: LoopThread, inner: RemoteScope) -> None:
        self._loop = loop
        self._inner = inner

    def __enter__(self) -> Self:
        self._loop.run(self._inner.__aenter__())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def number(self) -> int:
        return self._inner.number

    def open(self) -> None:
        """Make it at the station, if it is not there."""
        self._loop.run(self._inner.open())

    def close(self) -> None:
        """End it, with what it has recorded."""
        self._loop.run(self._inner.close())

    def start(self) -> dict[str, Any]:
        """Record from the next cycle on; the state."""
        return self._loop.run(self._inner.start())

    def stop(self) -> dict[str, Any]:
        """Record no more; what there is stays; the state."""
        return self._loop.run(self._inner.stop())

    def trigger(self) -> dict[str, Any]:
        """The moment is now; the state."""
        return self._loop.run(self._inner.trigger())

    def facts(self) -> dict[str, Any]:
        """The state."""
        return self._loop.run(self._inner.facts())

    def wait(self, within: float | None = None) -> dict[str, Any]:
        """Wait until the recording is done; the state. Raises TimeoutError."""
        return self._loop.run(self._inner.wait(within))

    def data(self) -> ScopeData:
        """Return the samples that are recorded now."""
        return self._loop.run(self._inner.data())
