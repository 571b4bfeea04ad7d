"""Cyclic exchange: frames made once, whose output bytes are the slaves' memory.

A frame that is not back when the next cycle begins is lost: nothing waits for it. Inputs are taken
over only from datagrams with the right working counter, else the last valid ones stay.

Source: ETG.1000.4 §5.4; 001 §2.3 for the frame.
"""

import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from achse.ethercat.frame import MAX_FRAME, Datagram, DatagramCommand, EthercatFrame
from achse.ethercat.master.process_image import MAILBOX_BITS, ProcessDatagram, ProcessImage
from achse.ethercat.registers import Register

_U16 = struct.Struct("<H")
_U64 = struct.Struct("<Q")
_STATES = struct.Struct("<HH")
"""AL states by OR, and how many slaves have them."""
_HEADER = 10
_COUNTER = 2
_FIRST = 16
"""Offset of the first datagram in a frame."""

_LENGTH_AT = 14
_COMMANDS = 1 << 12
"""Type in the word of the length."""
_MORE = 0x80
"""Bit of a datagram's byte 7: another follows."""

_INDICES = 0x80
"""Indices below are those of cyclic frames."""
_ROOM = MAX_FRAME - _FIRST

_FRAME_MISSING = 0x8000
"""Bit of the state words: the whole frame."""
_MAX_BITS = 15
_BRD, _FRMW = int(DatagramCommand.BRD), int(DatagramCommand.FRMW)

_LOOK_NS = 5_000_000
"""Period of reading the mailbox states; the longest time that a slave's own message waits."""


@dataclass(slots=True)
class CyclicCounters:
    """Frames since the last reset; `late` came after their cycle, `wrong` had a wrong counter."""

    sent: int = 0
    lost: int = 0
    late: int = 0
    wrong: int = 0


class _Part:
    """One datagram in a frame: `at` is where its header begins."""

    __slots__ = ("at", "counter_at", "inputs", "length", "process")

    def __init__(self, at: int, length: int, process: ProcessDatagram | None) -> None:
        self.at = at
        self.length = length
        self.counter_at = at + _HEADER + length
        self.process = process
        self.inputs: slice
        """Its inputs in the memory of all inputs."""


class _Template:
    """One frame: the bytes that are sent, and what its datagrams mean.

    `length` is that of the frame as it was sent last: without its last datagram, if that was left
    out. What comes back is compared with the sent frame as one large number, and so are the
    working counters with those that are right.
    """

    def __init__(self, datagrams: list[tuple[Datagram, ProcessDatagram | None]]) -> None:
        self.buffer = bytearray(EthercatFrame([each for each, _ in datagrams]).encode())
        self.parts: list[_Part] = []
        at = _FIRST
        for datagram, process in datagrams:
            self.parts.append(_Part(at, len(datagram.data), process))
            at += _HEADER + len(datagram.data) + _COUNTER
        self.length = len(self.buffer)
        self.away = False
        self.wrong = 0
        """Bit k: datagram k had a wrong counter in the last cycle; bit 15: the frame is missing."""
        self.processes = [each for each in self.parts if each.process is not None]
        self.inputs: slice
        self._fixed = self._mask(range(12, _FIRST), _headers(self.buffer, self.parts))
        self._rights = self._counters()
        self._gather: struct.Struct
        self._sent_headers: int
        self._short: int
        self._short_fixed: int
        self._short_head: tuple[bytes, int]
        self.renew()

    def _mask(self, *ranges: Iterable[int]) -> int:
        mask = bytearray(len(self.buffer))
        for each in ranges:
            for at in each:
                mask[at] = 0xFF
        return int.from_bytes(mask, "little")

    def _counters(self) -> tuple[int, int]:
        """Mask and values of the working counters of process data."""
        values = bytearray(len(self.buffer))
        for part in self.processes:
            assert part.process is not None
            _U16.pack_into(values, part.counter_at, part.process.working)
        places = [range(part.counter_at, part.counter_at + 2) for part in self.processes]
        return self._mask(*places), int.from_bytes(values, "little")

    def place(self, begin: int) -> int:
        """Let the inputs begin at `begin` of the memory of all; where they end."""
        form, at, first = "<", 0, begin
        for part in self.processes:
            assert part.process is not None
            data = part.at + _HEADER + part.process.output_end
            length = part.length - part.process.output_end
            part.inputs = slice(begin, begin + length)
            if length:
                form += f"{data - at}x{length}s"
                at = data + length
            begin += length
        self._gather = struct.Struct(form)
        self.inputs = slice(first, begin)
        return begin

    def renew(self) -> None:
        """Update the headers, which have changed."""
        self._sent_headers = int.from_bytes(self.buffer, "little") & self._fixed
        if len(self.parts) == 1:
            return
        end, before = self.parts[-1].at, self.parts[-2].at
        short = self.buffer[:end]
        _U16.pack_into(short, _LENGTH_AT, end - _FIRST | _COMMANDS)
        short[before + 7] &= ~_MORE
        self._short_fixed = self._fixed & ~(-1 << 8 * end)
        self._short = int.from_bytes(short, "little") & self._short_fixed
        self._short_head = bytes(short[_LENGTH_AT:_FIRST]), short[before + 7]

    def whole(self, index: int) -> bytes:
        """Return the frame to send."""
        self.buffer[_FIRST + 1] = index
        self.length = len(self.buffer)
        return bytes(self.buffer)

    def short(self, index: int) -> bytes:
        """Return the frame to send, without its last datagram."""
        self.buffer[_FIRST + 1] = index
        self.length = self.parts[-1].at
        frame = self.buffer[: self.length]
        frame[_LENGTH_AT:_FIRST], frame[self.parts[-2].at + 7] = self._short_head
        return bytes(frame)

    def same(self, packet: bytes, number: int) -> bool:
        """Return True if a packet has the datagrams that were sent; slaves change data and
        positions."""
        if len(packet) < self.length:
            return False
        if self.length < len(self.buffer):
            return number & self._short_fixed == self._short
        return number & self._fixed == self._sent_headers

    def right(self, number: int) -> bool:
        """Return True if all process data have the expected working counters."""
        mask, values = self._rights
        return number & mask == values

    def take(self, packet: bytes, inputs: bytearray) -> None:
        """Take over all inputs."""
        inputs[self.inputs] = b"".join(self._gather.unpack_from(packet))


def _headers(buffer: bytearray, parts: list[_Part]) -> Iterator[int]:
    """Yield the bytes of headers that slaves leave as they are."""
    for part in parts:
        yield part.at
        yield from range(part.at + (4 if buffer[part.at] == _BRD else 2), part.at + 8)


class _SharedByte:
    """A slave's bits in a byte of the frame that it shares; `own` is its memory, bits from 0 on."""

    __slots__ = ("_bit", "_mask", "_whole", "own")

    def __init__(self, whole: memoryview, bit: int, bits: int) -> None:
        self._whole = whole
        self._bit = bit
        self._mask = (1 << bits) - 1
        self.own = memoryview(bytearray(1))

    def put(self) -> None:
        """Copy the slave's memory to the frame."""
        other_bits = self._whole[0] & ~(self._mask << self._bit)
        self._whole[0] = other_bits | (self.own[0] & self._mask) << self._bit

    def take(self) -> None:
        """Copy the bits of the frame to the slave's memory."""
        self.own[0] = self._whole[0] >> self._bit & self._mask


class CyclicExchange:
    """The cyclic frames of a bus. `outputs(position)` and `inputs(position)` are memory."""

    def __init__(self, image: ProcessImage) -> None:
        self.image = image
        self.counters = CyclicCounters()
        self.present = 0
        """Slaves that answered in the last cycle that came back."""
        self.al_states = 0
        """AL status of all slaves, by OR."""
        self.reference_ns = 0
        """System time of the reference clock when the frame passed it."""
        self.reference_lost = False
        """True if a frame came back without the time of the reference: the next frames carry
        none."""
        self.mailbox_bits = b""
        self._cycle = 0
        self._look_cycles = max(_LOOK_NS // image.bus.cycle_ns, 1)
        self._with_clock = any(slave.clock for slave in image.bus.slaves)
        self._frames = [_Template(each) for each in self._packed()]
        self._clock = self._frames[0].parts[0] if self._with_clock else None
        self._place()

    def _packed(self) -> list[list[tuple[Datagram, ProcessDatagram | None]]]:
        """Return the datagrams, as many as fit into each frame."""
        wanted: list[tuple[Datagram, ProcessDatagram | None]] = []
        if self._with_clock:  # a place for the time; NOP until a reference clock is known
            wanted.append((Datagram(DatagramCommand.NOP, 0, bytes(8)), None))
        wanted += [
            (Datagram(each.command, each.logical, bytes(each.length)), each)
            for each in self.image.datagrams
        ]
        self._count_at = len(wanted)
        wanted.append((Datagram.at(DatagramCommand.BRD, 0, Register.AL_STATUS, bytes(2)), None))
        mailboxes = len(self.image.mailboxes)
        if mailboxes:
            bits = bytes(mailboxes + 7 >> 3)
            wanted.append((Datagram(DatagramCommand.LRD, MAILBOX_BITS, bits), None))
        frames: list[list[tuple[Datagram, ProcessDatagram | None]]] = [[]]
        room = _ROOM
        for each in wanted:
            size = _HEADER + len(each[0].data) + _COUNTER
            if size > room:
                frames.append([])
                room = _ROOM
            frames[-1].append(each)
            room -= size
        return frames

    def _place(self) -> None:
        """Place the memory: outputs are bytes of the frames, inputs are one block beside."""
        size = sum(each.length - each.output_end for each in self.image.datagrams)
        self._inputs = bytearray(size)
        self._output_views: dict[int, memoryview] = {}
        self._input_views: dict[int, memoryview] = {}
        inputs = memoryview(self._inputs)
        self._shared_outputs: list[_SharedByte] = []
        self._shared_inputs: list[_SharedByte] = []
        begin = 0
        for frame in self._frames:
            outputs = memoryview(frame.buffer)
            begin = frame.place(begin)
            for part in frame.processes:
                process = part.process
                for position, owner in self.image.writes.items():
                    if owner is process:
                        area = self.image.outputs[position]
                        first = part.at + _HEADER + area.first
                        view = outputs[first : first + area.length]
                        if area.bits:
                            shared = _SharedByte(view, area.bit, area.bits)
                            self._shared_outputs.append(shared)
                            view = shared.own
                        self._output_views[position] = view
                for position, owner in self.image.reads.items():
                    if owner is process:
                        area = self.image.inputs[position]
                        first = part.inputs.start + area.first - owner.output_end
                        view = inputs[first : first + area.length]
                        if area.bits:
                            shared = _SharedByte(view, area.bit, area.bits)
                            self._shared_inputs.append(shared)
                            view = shared.own
                        self._input_views[position] = view
        places = [(frame, part) for frame in self._frames for part in frame.parts]
        self._count_frame, self._count = places[self._count_at]
        last_frame, self._bits = places[-1]
        self._bits_frame = last_frame if self.image.mailboxes else None

    def outputs(self, position: int) -> memoryview:
        """Return the outputs of a slave: what is written here goes out with the next cycle."""
        return self._output_views.get(position, memoryview(bytearray()))

    def inputs(self, position: int) -> memoryview:
        """Return the last valid inputs of a slave, read-only."""
        return self._input_views.get(position, memoryview(b"")).toreadonly()

    def set_reference(self, station: int | None) -> None:
        """Set the slave whose time goes to all others, None for none."""
        self.reference_lost = False
        self._carry_time(station)

    def _carry_time(self, station: int | None) -> None:
        if self._clock is None:
            return
        command = DatagramCommand.NOP if station is None else DatagramCommand.FRMW
        head = Datagram.at(command, station or 0, Register.SYSTEM_TIME, b"")
        buffer, at = self._frames[0].buffer, self._clock.at
        buffer[at] = head.command
        buffer[at + 2 : at + 6] = head.address.to_bytes(4, "little")
        self._frames[0].renew()

    @property
    def frame_states(self) -> list[int]:
        """Of each frame: bit k for datagram k with a wrong counter, bit 15 for a missing frame."""
        return [each.wrong for each in self._frames]

    def frames(self) -> list[bytes]:
        """Return the frames of the next cycle; those of the last that are not back are lost."""
        self._cycle += 1
        for each in self._shared_outputs:
            each.put()
        frames = self._frames
        index = self._cycle * len(frames) % _INDICES
        quiet = self._cycle % self._look_cycles != 0
        sent = []
        for frame in frames:
            if frame.away:
                self._missing(frame)
            frame.away = True
            if not quiet or frame is not self._bits_frame:
                sent.append(frame.whole(index))
            elif len(frame.parts) > 1:
                sent.append(frame.short(index))
            else:
                frame.away = False
            index = (index + 1) % _INDICES
        self.counters.sent += len(sent)
        return sent

    def _missing(self, frame: _Template) -> None:
        self.counters.lost += 1
        frame.wrong = _FRAME_MISSING
        for part in frame.processes:
            assert part.process is not None
            part.process.valid = False
            part.process.wrong += 1

    @property
    def away(self) -> bool:
        """True if frames of the last cycle are not back."""
        return any(frame.away for frame in self._frames)

    def skip(self, cycles: int, elapsed_ns: int) -> None:
        """Count so many cycles that another kernel did as if with frames, all of them valid.

        `elapsed_ns` is their time. The kernel has written the inputs (`exchanged`).
        """
        self._cycle += cycles
        self.counters.sent += cycles * len(self._frames)
        if self.reference_ns:
            self.reference_ns += elapsed_ns
        for process in self.image.datagrams:
            process.fresh += cycles

    def exchanged(self, position: int) -> memoryview:
        """Return the inputs of a slave, for an exchange without frames."""
        return self._input_views.get(position, memoryview(bytearray()))

    def receive(self, packet: bytes) -> None:
        """Take a frame with an index below 0x80; a late or foreign one is counted and left."""
        frames = self._frames
        place = (packet[_FIRST + 1] - self._cycle * len(frames)) % _INDICES
        number = int.from_bytes(packet, "little")
        if place >= len(frames) or not frames[place].away or not frames[place].same(packet, number):
            self.counters.late += 1
            return
        frame = frames[place]
        frame.away = False
        if frame.right(number):
            frame.take(packet, self._inputs)
            for part in frame.processes:
                process = part.process
                process.valid = True  # type: ignore[union-attr]
                process.fresh += 1  # type: ignore[union-attr]
            frame.wrong = 0
        else:
            self._take_some(frame, packet)
        for each in self._shared_inputs:
            each.take()
        if frame is self._count_frame:
            self.al_states, self.present = _STATES.unpack_from(packet, self._count.at + _HEADER)
        if frame is self._bits_frame and frame.length > self._bits.at:
            at = self._bits.at + _HEADER
            self.mailbox_bits = packet[at : at + self._bits.length]
        if self._clock is not None and frame is frames[0]:
            at = self._clock.at + _HEADER
            (time_ns,) = _U64.unpack_from(packet, at)
            if time_ns and (packet[at + 8] or packet[at + 9]):
                self.reference_ns = time_ns
            elif packet[at - _HEADER] == _FRMW:  # others would follow a time of 0
                self.reference_lost = True
                self._carry_time(None)

    def _take_some(self, frame: _Template, packet: bytes) -> None:
        """Take over the inputs of datagrams with the right counter."""
        wrong = 0
        for bit, part in enumerate(frame.parts):
            process = part.process
            if process is None:
                continue
            (counter,) = _U16.unpack_from(packet, part.counter_at)
            if counter == process.working:
                process.valid = True
                process.fresh += 1
                first = part.at + _HEADER + process.output_end
                self._inputs[part.inputs] = packet[first : part.at + _HEADER + part.length]
            else:
                process.valid = False
                process.wrong += 1
                wrong |= 1 << min(bit, _MAX_BITS - 1)
        frame.wrong = wrong
        self.counters.wrong += 1

    def take_mailbox_bits(self) -> bytes:
        """Return the mailbox states of the last look, once; empty until the next."""
        bits, self.mailbox_bits = self.mailbox_bits, b""
        return bits
