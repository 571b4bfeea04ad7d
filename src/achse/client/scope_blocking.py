"""Scopes of a station without asyncio: the names of `achse.client.scope`, and they wait."""

from achse.client.scope import RemoteScope
from achse.client.wrapper import ContextWrapper, blocking


class BlockingScope(ContextWrapper[RemoteScope]):
    """One scope of a station; see `achse.client.scope.RemoteScope`, whose methods these are."""

    @property
    def number(self) -> int:
        return self._inner.number

    open = blocking(RemoteScope.open)
    close = blocking(RemoteScope.close)
    start = blocking(RemoteScope.start)
    stop = blocking(RemoteScope.stop)
    trigger = blocking(RemoteScope.trigger)
    facts = blocking(RemoteScope.facts)
    wait = blocking(RemoteScope.wait)
    data = blocking(RemoteScope.data)
