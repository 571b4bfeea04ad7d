"""The ADS service of slaves at a TCP port, in the thread of the frames of their bus."""

import asyncio

from achse.ams import NetId
from achse.codes.station import SERVICE_PORT
from achse.devices.slave_service import SlaveService
from achse.ethercat import Segment
from achse.faults.drive_list import DriveFaults
from achse.router import Router
from achse.transport.tcp.listener import TcpListener

_NET_ID = NetId("127.0.0.1.1.1")


class ControlPort:
    """The service at a TCP port, given its turns between the frames of the bus.

    It runs in the thread of the frames, which need neither lock nor wait.
    """

    def __init__(self, segment: Segment) -> None:
        self.faults = DriveFaults(segment)
        self.service = SlaveService(segment, self.faults)
        self._router = Router(_NET_ID)
        self.service.attach(self._router, SERVICE_PORT)
        self._loop = asyncio.new_event_loop()
        self._listener = TcpListener(self._router)

    def open(self, host: str, port: int) -> tuple[str, int]:
        """Listen at `host`:`port`, 0 for a free one; where it is. OSError if it is taken."""
        self._loop.run_until_complete(self._listener.open(host, port))
        return self._listener.host, self._listener.port

    def turn(self) -> None:
        """Begin and end faults that are due; answer what has come."""
        self.faults.tick()
        self._loop.call_soon(self._loop.stop)
        self._loop.run_forever()

    def close(self) -> None:
        """End all connections."""
        if self._listener.host:
            self._loop.run_until_complete(self._listener.close())
        self._loop.close()
