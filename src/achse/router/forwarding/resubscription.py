"""Choice of clients whose subscriptions and handles are made again behind a lost connection.

A client chooses for its connection by a request; else a rule of the configuration applies, and
without one the key of the target.
"""

import weakref
from collections.abc import Sequence
from typing import NamedTuple

from achse.ams import Endpoint, NetId


class ClientRule(NamedTuple):
    """The choice for clients at a host, with a NetId, or both; None and "" match any."""

    resubscribe: bool
    host: str = ""
    net_id: NetId | None = None

    def matches(self, client: Endpoint, source: bytes) -> bool:
        """True if the rule is for a client at this connection with this source address."""
        return (not self.host or getattr(client, "peer_host", "") == self.host) and (
            self.net_id is None or source[:6] == self.net_id
        )


class Resubscription:
    """Choices of all clients of a router; the first rule that matches applies."""

    def __init__(self, rules: Sequence[ClientRule] = ()) -> None:
        self._rules = tuple(rules)
        self._choices: weakref.WeakKeyDictionary[Endpoint, bool] = weakref.WeakKeyDictionary()
        """Requests of clients, by connection."""

    def __len__(self) -> int:
        """Connections whose client has chosen."""
        return len(self._choices)

    def choose(self, client: Endpoint, wanted: bool) -> None:
        """Apply the request of a client from now on to all that it fetches by this connection."""
        self._choices[client] = wanted

    def applies(self, client: Endpoint, source: bytes, default: bool) -> bool:
        """True if resources of this client are to be made again; `default` is the target's key."""
        chosen = self._choices.get(client)
        if chosen is not None:
            return chosen
        for rule in self._rules:
            if rule.matches(client, source):
                return rule.resubscribe
        return default
