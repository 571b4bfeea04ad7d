"""Interface of the station that faults need."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from achse.ams import AdsState
from achse.plc import PlcRuntime
from achse.router import Router
from achse.server import Device
from achse.transport.tcp.listener import TcpListener


class FaultyStation(Protocol):
    """A station as faults see it. What it consists of may be another after a restart."""

    @property
    def listeners(self) -> Sequence[TcpListener]: ...
    @property
    def devices(self) -> Sequence[Device]: ...
    @property
    def plcs(self) -> Mapping[int, PlcRuntime]: ...
    @property
    def router(self) -> Router: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def state(self) -> AdsState: ...

    @property
    def strict(self) -> bool:
        """True if the listeners accept one connection per remote host even without a fault."""
        ...

    def at(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` at a station time."""
        ...

    def after(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` behind the cycle at a station time."""
        ...

    def forget(self, action: Callable[[], None]) -> None:
        """Do not call this one any more. Unknown is not an error."""
        ...

    def restart(self) -> None: ...
    def configure(self) -> None: ...
