"""A target in memory behind a chain of routers."""

from io import BytesIO

from achse.ams import AmsAddress, NetId
from achse.router.forwarding.journal import HandleJournal
from tests.router.stations import Client, Host, Loop, Target, line_of

TARGET = NetId("5.0.0.9.1.1")
PLC = AmsAddress.of(TARGET, 851)
PYADS = AmsAddress("192.168.0.9.1.1:30000")


class Chain:
    """A target behind a chain of routers: `hosts[0]` is the farthest from it.

    With `journals` each of them has a journal of handles, which the next one in its place reads.
    """

    def __init__(self, routers: int, *, source_nat: bool = False, journals: bool = False) -> None:
        self.loop = Loop()
        self.target = Target(self.loop, TARGET)
        self.reachable = True
        own = [NetId(f"5.0.0.{n}.1.1") for n in range(1, routers + 1)]
        self.hosts = [Host(self.loop, net_id, source_nat) for net_id in own]
        self.files = {number: BytesIO() for number in range(routers) if journals}
        for number, host in enumerate(self.hosts):
            self._lead(host, number)
        self.count = 0

    def _lead(self, host: Host, number: int) -> None:
        if number in self.files:
            host.router.journal = HandleJournal(self.files[number])
        if number + 1 < len(self.hosts):
            host.leads(TARGET, lambda: self.hosts[number + 1])
        else:
            host.leads(TARGET, lambda: self.target if self.reachable else None)

    def client(self, host: int = 0, address: AmsAddress = PYADS) -> Client:
        self.count += 1
        return Client(self.hosts[host % len(self.hosts)], self.count - 1, address, PLC)

    def kill(self, router: int) -> None:
        """Kill a router; another one starts in its place at once, with nothing."""
        old = self.hosts[router]
        if router in self.files:
            self.files[router] = BytesIO(self.files[router].getvalue())
        old.kill()
        new = self.hosts[router] = Host(self.loop, old.router.net_id, old.router.source_nat)
        self._lead(new, router)
        if router in self.files:
            for uplink in new.uplinks:
                uplink.remembered()  # `achse router` reads the state of its targets

    def tick(self, times: int = 1) -> None:
        for _ in range(times):
            self.target.tick()
            self.loop.run(0.02)

    def restart_target(self) -> None:
        """It ends with all its connections, and starts with nothing."""
        for peer in list(self.target.peers):
            line_of(peer).abort()
        self.target = Target(self.loop, TARGET)
        self.loop.run(20.0)

    @property
    def forwarded(self) -> int:
        return sum(host.forwarded for host in self.hosts)
