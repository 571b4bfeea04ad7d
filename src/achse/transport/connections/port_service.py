"""The port service of a router: AMS/TCP packets by which local programs register ports.

Source: reference traffic (0x1000, 0x0001, 0x1002).
"""

from typing import TYPE_CHECKING

from achse.ams import AmsAddress, RouterError, TcpCommand, TcpMessage

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer

_PORTS_PER_CONNECTION = 256
"""Local ports of one peer; the programs of a computer share a connection at times."""

_PORTS_LEFT = 8192
"""So many client ports are only for peers that have none: they last for every connection."""


def serve_ports(peer: "Peer", message: TcpMessage) -> None:
    """Serve a request of `peer`, or end its connection."""
    if not peer.owner.serves_ports(peer.peer_host):
        peer.turn_out("it is not on this host, port service refused")
    elif message.command is TcpCommand.PORT_CONNECT and len(message.data) == 2:
        _register(peer, int.from_bytes(message.data, "little"))
    elif message.command is TcpCommand.PORT_CLOSE and len(message.data) == 2:
        _unregister(peer, int.from_bytes(message.data, "little"))
    elif message.command is TcpCommand.GET_LOCAL_NET_ID:
        _answer(peer, TcpCommand.GET_LOCAL_NET_ID, bytes(peer.router.net_id))
    elif message.command is not TcpCommand.ROUTER_NOTE:
        peer.turn_out(
            "%s with %d bytes of data is not a port service",
            *(message.command.name, len(message.data)),
        )


def _answer(peer: "Peer", command: TcpCommand, data: bytes) -> None:
    packet = TcpMessage(command, data).encode_tcp()
    peer.put((packet,), len(packet))


def _register(peer: "Peer", port: int) -> None:
    registered, router = len(peer.registered), peer.router
    if registered and (registered >= _PORTS_PER_CONNECTION or router.free_ports <= _PORTS_LEFT):
        peer.turn_out("it holds %d ports, further ones are for others", registered)
        return
    try:
        address = router.register(port, peer)
    except RouterError as refusal:
        peer.turn_out("%s", refusal)
        return
    peer.registered.append(address)
    _answer(peer, TcpCommand.PORT_CONNECT, bytes(address))


def _unregister(peer: "Peer", port: int) -> None:
    """Free a port of `peer`. With the last one gone its connection ends: clients wait."""
    address = AmsAddress.of(peer.router.net_id, port)
    if address in peer.registered:
        peer.registered.remove(address)
        peer.router.unregister(port)
        if not peer.registered:
            peer.close()
