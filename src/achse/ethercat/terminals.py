"""Virtual terminals: digital and analog inputs and outputs behind a slave controller, with CoE.

Bits and values are laid out as terminals of the field have them: a BIT for each digital channel,
16 bits of status and 16 of value for each analog input, 16 bits for each analog output.

Source: ETG.5001 for the objects of modular devices (6000h inputs, 7000h outputs); the layout of
common terminals as their files describe it.
"""

from collections.abc import Iterable, Sequence
from enum import IntFlag

from achse.codes import AbortCode, AlState, AlStatus, DataType, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.dictionary import (
    DictionaryIdentity,
    DictionaryObject,
    entry_of,
    number,
    record_object,
    text_object,
)

FULL_SCALE = 32767
"""The value of an analog channel at its full scale, 10 V."""

_LOCAL_CYCLE_NS = 250_000
_RO = int(ObjectAccess.READ)
_RW = int(ObjectAccess.READ | ObjectAccess.WRITE)
_RX_PDO, _TX_PDO = 0x1600, 0x1A00
_INPUTS, _OUTPUTS, _CHANNEL = 0x6000, 0x7000, 0x10
_WITHIN_KIND = 0xFFF
_VALUE = 0x11
"""Subindex of an analog value; the status is subindex 1."""
_MOST = {"digital": 64, "analog": 8}
_VOLTS = 10.0


class Terminal:
    """Base of terminals: a dictionary, a fixed mapping, outputs that fall to 0 outside Op.

    `output_image` contains the outputs that the master wrote last, `input_image` the inputs that it
    reads.
    """

    local_cycle_ns = _LOCAL_CYCLE_NS

    def __init__(
        self,
        name: str,
        product_code: int,
        outputs: Sequence[tuple[int, int, int]],
        inputs: Sequence[tuple[int, int, int]],
    ) -> None:
        """Entries are (index, subindex, bits), in the order in which they travel."""
        self.name = name
        self.identity = DictionaryIdentity(product_code=product_code)
        self.state = AlState.INIT
        self._outputs, self._inputs = tuple(outputs), tuple(inputs)
        self.output_size = sum(bits for *_, bits in outputs) + 7 >> 3
        self.input_size = sum(bits for *_, bits in inputs) + 7 >> 3
        self.output_image = bytes(self.output_size)
        self.input_image = bytes(self.input_size)
        self._objects = tuple(self._dictionary())

    def _dictionary(self) -> Iterable[DictionaryObject]:
        identity = tuple(vars(self.identity).values())
        yield DictionaryObject(
            *(0x1000, "Device type", ObjectCode.VAR, DataType.U32),
            (number(0, "Device type", 32, 0x0184_1389),),
        )
        yield text_object(0x1008, "Device name", self.name.encode("ascii", "replace"))
        yield _numbers(0x1018, "Identity", 32, identity)
        for index, name, entries in (
            (_RX_PDO, "Outputs mapping", self._outputs),
            (_TX_PDO, "Inputs mapping", self._inputs),
        ):
            mapped = [place << 16 | sub << 8 | bits for place, sub, bits in entries]
            yield _numbers(index, name, 32, mapped)
        yield _numbers(0x1C00, "SyncManager types", 8, (1, 2, 3, 4))
        for index, entries, pdo in (
            (0x1C12, self._outputs, _RX_PDO),
            (0x1C13, self._inputs, _TX_PDO),
        ):
            yield _numbers(index, "Assignment", 16, [pdo] if entries else [])
        for entries, access, name in (
            (self._inputs, _RO | ObjectAccess.TX_PDO, "Input"),
            (self._outputs, _RO | ObjectAccess.RX_PDO, "Output"),
        ):
            for index in dict.fromkeys(place for place, *_ in entries):
                yield _channel(index, name, access, [each for each in entries if each[0] == index])

    # objects

    def objects(self) -> tuple[DictionaryObject, ...]:
        return self._objects

    def read_object(self, index: int, subindex: int) -> bytes:
        """Return the value of an entry; raises `SdoAbort`."""
        entry = entry_of(self._objects, index, subindex)
        for entries, image in (
            (self._inputs, self.input_image),
            (self._outputs, self.output_image),
        ):
            bit = 0
            for place, sub, bits in entries:
                if (place, sub) == (index, subindex) and subindex:
                    value = int.from_bytes(image, "little") >> bit & (1 << bits) - 1
                    return value.to_bytes(bits + 7 >> 3, "little")
                bit += bits
        return entry.default or b""

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Refuse: no object is written by SDO."""
        entry_of(self._objects, index, subindex)
        raise SdoAbort(AbortCode.READ_ONLY)

    # process data and states

    def write_outputs(self, data: bytes) -> None:
        """Accept outputs from the master."""
        self.output_image = data

    def read_inputs(self) -> bytes:
        """Inputs to the master."""
        return self.input_image

    def enter(self, state: AlState, sync0_ns: int, cause: AlStatus) -> AlStatus:
        """Follow the state; outputs are off outside Op."""
        self.state = state
        if state is not AlState.OP:
            self.output_image = bytes(self.output_size)
        return AlStatus.NO_ERROR

    def step(self, elapsed_ns: int) -> AlStatus:
        """Nothing happens by time."""
        return AlStatus.NO_ERROR

    def take_emergency(self) -> bytes | None:
        """A terminal has none."""
        return None


class DigitalTerminal(Terminal):
    """Digital channels: `set_input` is the world outside, `output` what the master switched.

    Channels count from 0; at most 64 of each kind.
    """

    def __init__(self, inputs: int = 16, outputs: int = 16, name: str = "") -> None:
        _check(inputs, outputs, "digital")
        super().__init__(
            name or f"Digital {inputs} in {outputs} out",
            0x0D10_0000 | inputs << 8 | outputs,
            [(_OUTPUTS, number, 1) for number in range(1, outputs + 1)],
            [(_INPUTS, number, 1) for number in range(1, inputs + 1)],
        )
        self.inputs, self.outputs = inputs, outputs

    def set_input(self, channel: int, on: bool) -> None:
        """Switch an input; IndexError for a channel that is not there."""
        if not 0 <= channel < self.inputs:
            raise IndexError(f"inputs 0 to {self.inputs - 1}, got {channel}")
        bits = int.from_bytes(self.input_image, "little")
        bits = bits | 1 << channel if on else bits & ~(1 << channel)
        self.input_image = bits.to_bytes(self.input_size, "little")

    def output(self, channel: int) -> bool:
        """Return True if an output is on; IndexError for a channel that does not exist."""
        if not 0 <= channel < self.outputs:
            raise IndexError(f"outputs 0 to {self.outputs - 1}, got {channel}")
        return bool(int.from_bytes(self.output_image, "little") >> channel & 1)


class AnalogStatus(IntFlag):
    """Bits of an analog input's status word."""

    UNDERRANGE = 0x0001
    OVERRANGE = 0x0002
    ERROR = 0x0040
    INVALID = 0x4000
    TOGGLE = 0x8000


class AnalogTerminal(Terminal):
    """Analog channels of ±10 V: 32767 is 10 V.

    Channels count from 0; at most 8 of each kind. The toggle bit of a status word changes with each
    new value.
    """

    def __init__(self, inputs: int = 4, outputs: int = 4, name: str = "") -> None:
        _check(inputs, outputs, "analog")
        super().__init__(
            name or f"Analog {inputs} in {outputs} out",
            0x0A10_0000 | inputs << 8 | outputs,
            [(_OUTPUTS + _CHANNEL * number, _VALUE, 16) for number in range(outputs)],
            [
                (_INPUTS + _CHANNEL * number, sub, 16)
                for number in range(inputs)
                for sub in (1, _VALUE)
            ],
        )
        self.inputs, self.outputs = inputs, outputs
        self._words = [(AnalogStatus(0), 0)] * inputs

    def set_voltage(self, channel: int, volts: float) -> None:
        """Set the voltage at an input, V; beyond ±10 V the status reports it. IndexError,
        ValueError."""
        if not 0 <= channel < self.inputs:
            raise IndexError(f"inputs 0 to {self.inputs - 1}, got {channel}")
        if volts != volts:  # not a number
            raise ValueError("a voltage is a number")
        status = self._words[channel][0] & AnalogStatus.TOGGLE ^ AnalogStatus.TOGGLE
        if volts > _VOLTS:
            status |= AnalogStatus.OVERRANGE | AnalogStatus.ERROR
        elif volts < -_VOLTS:
            status |= AnalogStatus.UNDERRANGE | AnalogStatus.ERROR
        value = round(min(max(volts, -_VOLTS), _VOLTS) / _VOLTS * FULL_SCALE)
        self._words[channel] = status, value
        self.input_image = b"".join(
            int(word).to_bytes(2, "little") + number.to_bytes(2, "little", signed=True)
            for word, number in self._words
        )

    def voltage(self, channel: int) -> float:
        """Return the voltage of an output, V; IndexError for a channel that does not exist."""
        if not 0 <= channel < self.outputs:
            raise IndexError(f"outputs 0 to {self.outputs - 1}, got {channel}")
        data = self.output_image[2 * channel : 2 * channel + 2]
        return int.from_bytes(data, "little", signed=True) / FULL_SCALE * _VOLTS


def _check(inputs: int, outputs: int, kind: str) -> None:
    most = _MOST[kind]
    if not (0 <= inputs <= most and 0 <= outputs <= most and inputs + outputs):
        raise ValueError(f"a terminal has 1 to {most} {kind} channels, got {inputs} and {outputs}")


def _channel(
    index: int, name: str, access: int, entries: Sequence[tuple[int, int, int]]
) -> DictionaryObject:
    objects = [
        number(sub, f"{name} {sub}", bits, access=access, signed=sub == _VALUE)
        for _, sub, bits in entries
    ]
    place = (index & _WITHIN_KIND) // _CHANNEL + 1
    return record_object(index, f"{name} {place}", objects, max(sub for _, sub, _ in entries))


def _numbers(index: int, name: str, bits: int, values: Sequence[int]) -> DictionaryObject:
    entries = [number(n, f"{name} {n}", bits, value) for n, value in enumerate(values, 1)]
    return record_object(index, name, entries)
