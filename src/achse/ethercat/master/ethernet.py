"""The network of a bus: slaves with EoE at one switch, and what of this process attaches there.

Source: ETG.1000.6 §5.7.1.
"""

from collections.abc import Callable, Sequence

from achse.ethercat.description import MailboxBit
from achse.ethercat.master.bus_slave import BusSlave
from achse.ethercat.master.ethernet_switch import EthernetSwitch, SwitchPort
from achse.ethercat.master.steps import Steps

_MOST_WAITING = 32
"""Frames on their way to one slave; more are dropped, as a switch does it."""


class BusEthernet:
    """Frames between the slaves that speak EoE (by EEPROM, ESI or ENI) and the host.

    `switch` has a port for each of these slaves; the host takes one by `switch.attach`. `run` does
    steps on the bus.
    """

    def __init__(
        self, slaves: Sequence[BusSlave], run: Callable[[Steps[None], Callable[[], None]], object]
    ) -> None:
        self.switch = EthernetSwitch()
        self._run = run
        self.ports: dict[int, SwitchPort] = {}
        """By station address."""
        for slave in slaves:
            if slave.eoe is not None and slave.configuration.protocols & MailboxBit.EOE:
                self._join(slave)

    def _join(self, slave: BusSlave) -> None:
        eoe = slave.eoe
        assert eoe is not None
        waiting = 0

        def ended() -> None:
            nonlocal waiting
            waiting -= 1

        def forward(frame: bytes) -> None:
            nonlocal waiting
            if not slave.speaks or waiting >= _MOST_WAITING:
                port.dropped += 1
                return
            waiting += 1
            self._run(eoe.send(frame), ended)

        port = self.ports[slave.station] = self.switch.attach(slave.name, forward)
        eoe.take = lambda frame: self.switch.send(port, frame)
