"""Faults of TCP connections: they break off, are refused, or close each other."""

from typing import Annotated, Literal

from achse.faults.fault import ActiveFault, LastingFault, Undo, text
from achse.faults.selection import client_test
from achse.faults.site import Setting, Site, StationFault


class DropLink(StationFault):
    """TCP connections break off."""

    kind: Literal["drop_link"] = "drop_link"
    client: Annotated[str, text()] = ""
    """A NetId, an AMS address or an IP address."""

    def check(self, site: Site) -> None:
        client_test(self.client)

    def begin(self, site: Site, active: ActiveFault) -> None:
        is_client = client_test(self.client)
        for listener in site.target.listeners:
            for connection in list(listener.connections):
                addresses = (*connection.registered, *connection.senders) or (b"",)
                if any(is_client(address, connection.peer_host) for address in addresses):
                    listener.loop.call_soon(connection.abort)  # its request is answered first


class RefuseLinks(LastingFault, StationFault):
    """New TCP connections are closed at once."""

    kind: Literal["refuse_links"] = "refuse_links"

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        return site.set(Setting(closed=True))


class OneConnection(LastingFault, StationFault):
    """One TCP connection per remote host: a second one closes the first."""

    kind: Literal["one_connection"] = "one_connection"

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        return site.set(Setting(strict=True))
