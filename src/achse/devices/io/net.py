"""The NetId of a bus: ports of its own, beside those of the station."""

from collections.abc import Callable

from achse.ams import AmsAddress, Command, Endpoint, Frame, NetId, RouterError
from achse.codes import ReturnCode
from achse.router import Router


class BusNet:
    """Ports at another NetId than the router's; devices attach here as they would there.

    Requests for a port without a device are answered with AMS error 0x6.
    """

    def __init__(self, router: Router, net_id: NetId) -> None:
        self.net_id = net_id
        self._router = router
        self._ports: dict[bytes, Endpoint] = {}
        router.add_route(net_id, self)

    def close(self) -> None:
        """Take the NetId off the router."""
        self._router.remove_route(self.net_id)

    # what a device needs of its router

    def register(self, port: int, endpoint: Endpoint) -> AmsAddress:
        """Put a device at a port of this NetId; RouterError if it is taken."""
        address = AmsAddress.of(self.net_id, port)
        if address in self._ports:
            raise RouterError(ReturnCode.ROUTER_PORT_IN_USE, f"port {port}")
        self._ports[address] = endpoint
        return address

    def unregister(self, port: int) -> None:
        """Free a port. Unknown is not an error."""
        self._ports.pop(AmsAddress.of(self.net_id, port), None)

    def reaches(self, address: bytes) -> bool:
        """Return True if a response to an address can be routed now."""
        return address in self._ports or self._router.reaches(address)

    def on_port_closed(self, listener: Callable[[AmsAddress], None]) -> None:
        """Call `listener` with the address of each client's port that is freed."""
        self._router.on_port_closed(listener)

    def ignore_port_closed(self, listener: Callable[[AmsAddress], None]) -> None:
        """Undo `on_port_closed`."""
        self._router.ignore_port_closed(listener)

    def on_way_closed(
        self, listener: Callable[[Endpoint], None], uses: Callable[[Endpoint], bool] | None = None
    ) -> None:
        """Call `listener` with each connection that ends; `uses` returns True for one in use."""
        self._router.on_way_closed(listener, uses)

    def ignore_way_closed(self, listener: Callable[[Endpoint], None]) -> None:
        """Undo `on_way_closed`."""
        self._router.ignore_way_closed(listener)

    # frames

    def deliver(self, frame: Frame) -> bool:
        """Hand a request to the device at its port, and what devices answer to the router."""
        if frame.target[:6] != self.net_id:
            return self._router.deliver(frame)
        endpoint = self._ports.get(frame.target)
        if endpoint is not None:
            return endpoint.deliver(frame)
        if frame.is_response or frame.command == Command.NOTIFICATION:
            return False
        return self._router.deliver(frame.reply(error=ReturnCode.TARGET_PORT_NOT_FOUND.number))
