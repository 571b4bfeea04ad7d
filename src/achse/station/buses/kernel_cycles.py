"""The shortcut: cycles in which a bus of virtual drives carries nothing but valid process data.

Frames in Python cost twenty times what axes and drives do. As long as master, slaves and drives
have nothing else to do, their cycles are done in one kernel; the state afterwards is that which
frames would have left. Simple terminals beside the drives exchange their data after each cycle, so
that cycles are done one by one with them.
"""

import ctypes
from collections.abc import Callable
from typing import Any

from achse.drive.compiled import Bank
from achse.drive.drive import LONGEST_CYCLE_NS
from achse.ethercat.master import BusSlave
from achse.ethercat.process_buffers import exchange_buffers
from achse.ethercat.terminals import Terminal
from achse.motion import Nc
from achse.motion.servo import Servos
from achse.native.memory import Rows
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.whole_cycle import KERNEL, STRAND


class KernelCycles:
    """Does cycles of an NC and its only bus, if that is possible now."""

    def __init__(self, nc: Nc, servos: Servos, bus: EthercatBus) -> None:
        self._nc, self._servos, self._bus = nc, servos, bus
        slaves = bus.segment.slaves
        self._drive_slaves = [slaves[each.position] for each in bus.slaves]
        self._terminals = [(each, slaves[each.position]) for each in bus.terminal_slaves]
        self._run: Callable[[int], int] | None = None
        self._arguments: tuple[Any, ...] = ()
        self.allowed = (
            nc.compiled
            and bus.bank is not None
            and all(map(self._is_passive, bus.terminals, bus.terminal_slaves))
            and KERNEL.available
            and KERNEL.cached
        )
        """True if its machine code is cached (`achse warmup` compiles it); other parts may clear
        it."""
        self.cycles = 0
        """Number of cycles that the machine code has done."""
        cycle_ns = bus.cycle_ns
        self._drive_cycles = -(-cycle_ns // LONGEST_CYCLE_NS)
        self._drive_dt = cycle_ns * 1e-9 / self._drive_cycles
        self._strands = Rows(STRAND, len(bus.slaves))
        self._parts: list[tuple[slice, slice]] = []
        read = written = 0
        for n, slave in enumerate(bus.slaves):
            row = self._strands.row(n).cast("q")
            row[STRAND.fields["record"].offset] = n
            row[STRAND.fields["inputs"].offset] = read
            row[STRAND.fields["outputs"].offset] = written
            ends = read + len(slave.inputs), written + len(slave.outputs)
            self._parts.append((slice(read, ends[0]), slice(written, ends[1])))
            read, written = ends

    def _is_passive(self, device: object, slave: BusSlave) -> bool:
        """Return True for a terminal that does nothing by time, and has bytes of its own in the
        frames."""
        image = self._bus.master.image
        shares = image.outputs[slave.position].bits or image.inputs[slave.position].bits
        return isinstance(device, Terminal) and type(device).step is Terminal.step and not shares

    def run(self, count: int) -> int:
        """Do up to `count` cycles; return how many were done, 0 if frames have to do them."""
        bus = self._bus
        segment = bus.segment
        if not self.allowed or bus.faults or segment.disturbance is not None or not segment.whole:
            return 0
        cycle_ns = bus.cycle_ns
        room = (bus.master.quiet_until_ns - 1 - bus.now_ns) // cycle_ns
        if room <= 0:
            return 0
        for slave in self._drive_slaves:
            if not slave.steps_by(cycle_ns):
                return 0
        for drive in bus.drives:
            if drive.kernel_record(cycle_ns) is None:
                return 0
        for servo in self._servos.servos:
            if not (servo.valid and servo.has_begun):
                return 0
        for _, slave in self._terminals:
            if not slave.exchanges_only:
                return 0
        return self._skip(1 if self._terminals else min(count, room))

    def _skip(self, count: int) -> int:
        bus, servos = self._bus, self._servos
        if self._arguments is not self._nc.kernel_arguments:
            self._bind()
        assert self._run is not None
        inputs, outputs = servos.inputs, servos.outputs
        for slave, (part, _) in zip(bus.slaves, self._parts, strict=True):
            inputs[part] = slave.inputs
        outcome = self._run(count)
        unfinished, done = outcome < 0, abs(outcome)
        whole = done - unfinished
        elapsed = whole * bus.cycle_ns
        bus.now_ns += elapsed
        bus.segment.time.now_ns += elapsed
        for each in self._drive_slaves:
            each.skip(elapsed, bus.cycle_ns if unfinished else 0)
        bus.master.skip(whole)
        for slave, drive, (read, written) in zip(bus.slaves, bus.drives, self._parts, strict=True):
            bus.master.cyclic.exchanged(slave.position)[:] = inputs[read]
            slave.outputs[:] = outputs[written]
            drive.take_steps(None if unfinished else bytes(outputs[written]))
        if unfinished:
            bus.exchange()
        elif self._terminals:
            bus.segment.advance(bus.now_ns)
            for terminal, own in self._terminals:
                managers, outgoing = own.esc.sync_managers, bytes(terminal.outputs)
                arguments = exchange_buffers(own.buffers, managers, outgoing)
                bus.master.cyclic.exchanged(terminal.position)[:] = arguments
        self.cycles += whole
        return done

    def _bind(self) -> None:
        bank = self._bus.bank
        assert isinstance(bank, Bank)
        drives, servos = bank.rows, self._servos
        memories = [
            (ctypes.c_char * len(image)).from_buffer(image)
            for image in (servos.inputs, servos.outputs)
        ]
        images = [part for memory in memories for part in (ctypes.addressof(memory), len(memory))]
        self._arguments = self._nc.kernel_arguments
        bound = KERNEL.bind(
            *self._arguments,
            *servos.kernel_arguments,
            *(self._strands.address, self._strands.count),
            *(drives.address, drives.count),
            *(drives.address, drives.count * drives.size // 8),
            *images,
            *(self._drive_dt, self._drive_cycles),
        )

        def run(count: int) -> int:
            assert memories  # they stay where they are
            done: int = bound(count)
            return done

        self._run = run
