"""Rights of each sender of one connection."""

import logging

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right, needed_rights

log = logging.getLogger("achse.tcp")


class SenderRights:
    """The rights of the senders of a connection; false while each of them may everything."""

    def __init__(self) -> None:
        self.limited: dict[bytes, Right] = {}
        """Rights of those that may not everything."""
        self._reported_rights = NO_RIGHTS
        self._lie_reported = False

    def __bool__(self) -> bool:
        return bool(self.limited)

    def assign(self, source: bytes, rights: Right) -> Right:
        """Set the rights of `source`; return those that it has lost."""
        before = self.limited.pop(source, ALL_RIGHTS)
        if rights != ALL_RIGHTS:
            self.limited[source] = rights
        return before & ~rights

    def forget(self, source: bytes) -> None:
        """Forget a sender that sends no more."""
        self.limited.pop(source, None)

    def missing(self, frame: Frame) -> Right:
        """Return the rights that the sender of a request needs and does not have."""
        if frame.is_response or frame.command == Command.NOTIFICATION:
            return NO_RIGHTS
        return needed_rights(frame) & ~self.limited.get(frame.source, ALL_RIGHTS)

    def report(self, source: bytes, missing: Right, peer: str) -> None:
        """Log that the sender has not this right, once for each right."""
        if missing & ~self._reported_rights:
            self._reported_rights |= missing
            client = AmsAddress(source)
            log.warning(
                "%s may not %s here: refused with 0x723, as whatever it asks of that kind",
                *(client, str(missing.name).lower().replace("|", ", ")),
                extra={"client": str(client), "peer": peer},
            )

    def report_spoofing(self, source: bytes, peer: str) -> None:
        """Log that the sender gives an address that belongs to another one's port, once."""
        if not self._lie_reported:
            self._lie_reported = True
            client = str(AmsAddress(source))
            log.warning(
                "%s sends as %s, which is the port of another program: refused with 0x723",
                *(peer, client),
                extra={"client": client, "peer": peer},
            )


def missing_route(net_id: bytes, host: str) -> str:
    """Return the text that a client has no route, and how to add one."""
    client = NetId(net_id)
    return (
        f"client {client} from {host} has no route here; add it with `achse ads route add` or a"
        f' [[route]] in the station\'s configuration: net_id = "{client}", host = "{host}"'
    )
