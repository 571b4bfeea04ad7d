"""Terminals on buses: their inputs are bytes of %I of a PLC, bytes of %Q are their outputs.

In each cycle of the bus the PLC gets the inputs of the last frame before its programs run, and what
they wrote goes out with the next frame. A PLC that does not run has its outputs off, one that is
at a breakpoint keeps them. Inputs of a slave that does not take part stay as they were.
"""

from collections.abc import Sequence

from achse.devices.io import default_net_id
from achse.ethercat.master import BusSlave
from achse.plc import PlcRuntime
from achse.plc.memory import Area
from achse.plc.runtime import PlcState
from achse.station.building.building import Building
from achse.station.building.bus_parts import attach_buses, make_bus, served_bus, terminals_on
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.buses.plan import BusPlan
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.terminal import TerminalConfig
from achse.station.configuration.types import ConfigError


class _Link:
    """A terminal joined with a PLC."""

    def __init__(self, slave: BusSlave, plc: PlcRuntime, config: TerminalConfig) -> None:
        self.slave = slave
        self.plc = plc
        self.read, self.written = config.input_address, config.output_address

    def take(self) -> None:
        """Pass inputs to the PLC, if they are valid."""
        if self.read is not None and self.slave.working:
            self.plc.memory[Area.INPUT].write(self.read, bytes(self.slave.inputs))

    def send(self) -> None:
        """Fetch outputs from the PLC, if it runs."""
        outputs = self.slave.outputs
        if self.written is None or self.plc.is_halted:
            return
        if self.plc.state is PlcState.RUN:
            outputs[:] = self.plc.memory[Area.OUTPUT].read(self.written, len(outputs))
        else:
            outputs[:] = bytes(len(outputs))


class TerminalBus:
    """The terminals of one bus and the PLCs that they are joined with.

    A bus of terminals alone exchanges its frames here, in `take` and `send`; one that has drives
    does that in the cycle of the NC.
    """

    def __init__(
        self,
        bus: EthercatBus | InterfaceBus,
        configs: Sequence[TerminalConfig],
        plcs: Sequence[PlcRuntime | None],
        *,
        exchanges: bool = True,
    ) -> None:
        """`plcs` has the PLC of each terminal; without `exchanges` others send and receive."""
        self.bus = bus
        self._exchanges = exchanges
        self._joined = [
            (number, config, plc)
            for number, (config, plc) in enumerate(zip(configs, plcs, strict=True))
            if plc is not None
        ]
        self._links: list[_Link] = []
        self._link()
        bus.on_renewal(self._link)

    def _link(self) -> None:
        """Join the PLCs with the slaves that there are now."""
        slaves = self.bus.terminal_slaves
        self._links = [_Link(slaves[number], plc, config) for number, config, plc in self._joined]

    def take(self, now_ns: int) -> None:
        """Pass on the inputs of the last frame, before the programs."""
        if self._exchanges:
            self.bus.take()
        for link in self._links:
            link.take()

    def send(self, now_ns: int) -> None:
        """Exchange outputs and inputs, behind the programs."""
        for link in self._links:
            link.send()
        if self._exchanges:
            self.bus.exchange()


def make_terminals(building: Building) -> None:
    """Join the terminals of all buses with the PLCs. Raises ConfigError."""
    config = building.ground.config
    names = [bus.name for bus in config.bus]
    taken: dict[str, str] = {}
    for number, terminal in enumerate(config.terminal, 1):
        key = f"terminal[{number}]"
        if not names:
            raise ConfigError(f"{key}: expected a table [[bus]] for the terminals")
        if terminal.bus not in names and (terminal.bus is not None or len(names) > 1):
            listed = ", ".join(names)
            raise ConfigError(f"{key}.bus: expected one of {listed}, got {terminal.bus!r}")
        if terminal.name in taken:
            raise ConfigError(f"{key}.name: {taken[terminal.name]} has the name {terminal.name!r}")
        taken[terminal.name] = key
    served = []
    for number, bus in enumerate(config.bus, 1):
        own = terminals_on(config, bus)
        fieldbus = building.fieldbuses.get(bus.name)
        if not own and (fieldbus is not None or bus.interface is None):
            continue
        shared = fieldbus is not None
        if fieldbus is None:
            try:
                fieldbus = make_bus(
                    building, BusPlan(bus, (), own, bus.cycle, building.ground.base)
                )
            except ValueError as fault:
                raise ConfigError(f"bus[{number}]: {fault}") from None
            building.fieldbuses[bus.name] = fieldbus
            building.add_state(fieldbus.digest)
            net_id = default_net_id(building.ground.router.net_id, number)
            served.append(served_bus(number, fieldbus, net_id))
        _join(building, bus.name, fieldbus, [(taken[each.name], each) for each in own], shared)
    if served:
        attach_buses(building, served)


def _join(
    building: Building,
    name: str,
    bus: EthercatBus | InterfaceBus,
    terminals: Sequence[tuple[str, TerminalConfig]],
    shared: bool,
) -> None:
    plcs = [_plc(building, key, terminal) for key, terminal in terminals]
    for (key, terminal), slave, plc in zip(terminals, bus.terminal_slaves, plcs, strict=True):
        if plc is not None:
            _check(key, "input_address", terminal.input_address, plc, Area.INPUT, slave.inputs)
            _check(key, "output_address", terminal.output_address, plc, Area.OUTPUT, slave.outputs)
    joined = TerminalBus(bus, [each for _, each in terminals], plcs, exchanges=not shared)
    # the NC exchanges the frames of a shared bus; its inputs are there behind it
    for place, what, run in (
        (PhasePlace.NC if shared else PhasePlace.INPUTS, "inputs", joined.take),
        (PhasePlace.OUTPUTS, "outputs", joined.send),
    ):
        phase = CyclicPhase(place, f"{what} of {name}", bus.cycle_ns, run)
        building.add_phase(phase, bus.cycle_ns)
    if isinstance(bus, EthercatBus):
        devices = zip(terminals, bus.terminals, strict=True)
        building.terminals.update({each.name: device for (_, each), device in devices})


def _plc(building: Building, key: str, terminal: TerminalConfig) -> PlcRuntime | None:
    """Return the PLC of a terminal, None if nothing of it is linked."""
    if terminal.input_address is None and terminal.output_address is None:
        return None
    port = next(iter(building.plcs), 0) if terminal.plc is None else terminal.plc
    plc = building.plcs.get(port)
    if plc is None:
        there = ", ".join(map(str, building.plcs)) or "none"
        raise ConfigError(f"{key}.plc: expected the port of a [[plc]] ({there}), got {port}")
    return plc


def _check(
    key: str, what: str, address: int | None, plc: PlcRuntime, area: Area, image: memoryview
) -> None:
    size = plc.memory.sizes[area]
    if address is not None and address + len(image) > size:
        raise ConfigError(
            f"{key}.{what}: {len(image)} bytes from {area.value}B{address} on, there are {size}"
        )
