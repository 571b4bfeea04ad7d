"""An NC seen from outside: its axes through ADS services, ours and real ones alike.

Services are named as their rows in `achse.devices.nc` are; numbers and layouts are there.
"""

import asyncio
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from achse.ams import AdsError, DecodeError, DeviceError
from achse.ams.states import TransmissionMode
from achse.client import Subscription, Target
from achse.codes import ReturnCode
from achse.devices.nc.device import AXIS_GROUPS, RING0_GROUPS
from achse.motion.states import StateBit
from achse.server import Codec, Service

__all__ = [
    "CYCLIC",
    "FUNCTIONS",
    "PARAMETERS",
    "STATES",
    "NcAxis",
    "ServiceGroup",
    "UnknownAxis",
    "axes_of",
    "chosen",
    "flag_names",
    "motion_state",
]

MAX_AXES = 255

STEADY_STATE = (
    (StateBit.ERROR, "ErrorStop"),
    (StateBit.MOTION_COMMANDS_LOCKED, "Stopping"),
    (StateBit.PROTECTED, "SynchronizedMotion"),
    (StateBit.HOMING_BUSY, "Homing"),
    (StateBit.HAS_JOB | StateBit.CONTINUOUS_MOTION, "ContinuousMotion"),
    (StateBit.HAS_JOB, "DiscreteMotion"),
)
"""PLCopen state by the bits of StateDWord; the first whose bits are all set counts."""


class UnknownAxis(AdsError):
    """No axis of the NC has that id or name."""


class ServiceGroup(NamedTuple):
    """An index group, or the first of one per axis id, and its services by name."""

    base: int
    rows: dict[str, Service]

    @classmethod
    def of(cls, base: int, rows: Iterable[Service]) -> "ServiceGroup":
        return cls(base, {row.name: row for row in rows})


PARAMETERS, STATES, FUNCTIONS, CYCLIC = (ServiceGroup.of(*group[:2]) for group in AXIS_GROUPS[:4])
_RING0_STATES = ServiceGroup.of(*RING0_GROUPS[1])


def motion_state(state_dword: int) -> str:
    """The PLCopen state of an axis."""
    for bits, name in STEADY_STATE:
        if state_dword & bits == bits:
            return name
    enabled = state_dword & (StateBit.OPERATIONAL | StateBit.CONTROL_LOOP_CLOSED)
    return "Standstill" if enabled else "Disabled"


def flag_names(state_dword: int) -> list[str]:
    """The bits of StateDWord that are set, in words."""
    return [bit.name.lower().replace("_", " ") for bit in StateBit if state_dword & bit]


class NcAxis:
    """One axis behind the NC's port 500 or 501. All methods raise `AdsError`."""

    def __init__(self, nc: Target, axis_id: int, name: str = "", unit: str = "") -> None:
        self.nc = nc
        self.axis_id = axis_id
        self.name = name
        self.unit = unit

    async def read(self, area: ServiceGroup, service: str, *, element: int = 0) -> Any:
        """The value of a service, of sub-element `element`; structures as dictionaries by field."""
        row = area.rows[service]
        with self._refusing(row):
            return await _read(self.nc, area.base + self.axis_id, row, element)

    async def write(self, area: ServiceGroup, service: str, *values: Any, element: int = 0) -> None:
        """Write a value, of sub-element `element`, or call a function."""
        row = area.rows[service]
        with self._refusing(row):
            await self.nc.write_raw(
                area.base + self.axis_id, _offset(row, element), _encoded(row, values)
            )

    async def exchange(self, area: ServiceGroup, service: str, *values: Any) -> Any:
        """Call a function that answers."""
        row = area.rows[service]
        response = _layouts(row.response)[-1]
        with self._refusing(row):
            data = await self.nc.read_write_raw(
                area.base + self.axis_id, row.offset, response.size or 0, _encoded(row, values)
            )
        return _decoded(response, data, row.name)

    @contextmanager
    def _refusing(self, row: Service) -> Iterator[None]:
        """Refusals name axis and service."""
        try:
            yield
        except DeviceError as refusal:
            words = row.name.replace("_", " ")
            raise DeviceError(refusal.code, f"{self}, {words}") from refusal

    async def online(self) -> dict[str, Any]:
        """The online structure (002, 0x4100 + id: 0), by field."""
        online: dict[str, Any] = await self.read(STATES, "axis_online_structure")
        return online

    def samples(self, cycle_time: float) -> Subscription:
        """The cyclic structure (0x4300 + id: 0x80) each `cycle_time` seconds, as bytes."""
        row = CYCLIC.rows["nc_to_plc_structure"]
        return self.nc.subscribe_as(
            CYCLIC.base + self.axis_id,
            row.offset,
            _layouts(row.codec)[-1].size or 0,
            cycle_time=cycle_time,
            mode=TransmissionMode.SERVER_CYCLE,
        )

    def sample(self, data: bytes) -> dict[str, Any]:
        """The fields of a sample of `samples`."""
        row = CYCLIC.rows["nc_to_plc_structure"]
        values: dict[str, Any] = _decoded(_layouts(row.codec)[-1], data, row.name)
        return values

    def __str__(self) -> str:
        return self.name or f"axis {self.axis_id}"


async def axes_of(nc: Target) -> list[NcAxis]:
    """All axes of the NC, by id."""
    row = _RING0_STATES.rows["axis_ids"]
    data = await nc.read_raw(_RING0_STATES.base, row.offset, 4 * MAX_AXES)
    ids = _decoded(_layouts(row.codec)[-1], data, row.name)
    return list(await asyncio.gather(*(_axis(nc, axis_id) for axis_id in ids if axis_id)))


async def chosen(nc: Target, wanted: Sequence[str]) -> list[NcAxis]:
    """The axes with these ids or names (without case), all of them if none is wanted.

    Raises UnknownAxis.
    """
    ids = [int(word) for word in wanted if word.isdecimal() and 0 < int(word) <= MAX_AXES]
    if wanted and len(ids) == len(wanted):
        return list(await asyncio.gather(*(_axis(nc, axis_id) for axis_id in ids)))
    axes = await axes_of(nc)
    known = {axis.name.lower(): axis for axis in reversed(axes)}
    known |= {str(axis.axis_id): axis for axis in axes}
    for word in wanted:
        if word.lower() not in known:
            names = ", ".join(f"{axis.axis_id} {axis.name}".strip() for axis in axes)
            raise UnknownAxis(f"no axis {word!r} at {nc.address}; there are: {names or 'none'}")
    return [known[word.lower()] for word in wanted] or axes


async def _axis(nc: Target, axis_id: int) -> NcAxis:
    axis = NcAxis(nc, axis_id)
    axis.name, axis.unit = await asyncio.gather(
        axis.read(PARAMETERS, "axis_name"), axis.read(PARAMETERS, "physical_unit")
    )
    return axis


def _offset(row: Service, element: int) -> int:
    """Sub-element n is at 0x00n0_0000 + offset; a row without them is that of the axis."""
    return row.offset + (element << 20 if row.element is not None else 0)


async def _read(nc: Target, group: int, row: Service, element: int = 0) -> Any:
    layouts, offset = _layouts(row.codec), _offset(row, element)
    try:
        data = await nc.read_raw(group, offset, layouts[-1].size or 0)
    except DeviceError as refusal:  # an older NC knows the shorter structure only
        if refusal.code != ReturnCode.INVALID_SIZE.number or len(layouts) == 1:
            raise
        data = await nc.read_raw(group, offset, layouts[0].size or 0)
    codec = next((item for item in layouts if item.size == len(data)), layouts[-1])
    return _decoded(codec, data, row.name)


def _layouts(codec: Codec | tuple[Codec, ...]) -> tuple[Codec, ...]:
    """All layouts of a row, the one of TwinCAT 3 last."""
    return codec if isinstance(codec, tuple) else (codec,)


def _encoded(row: Service, values: tuple[Any, ...]) -> bytes:
    codec = _layouts(row.codec)[-1]
    return codec.encode(values[0] if len(values) == 1 else values)


def _decoded(codec: Codec, data: bytes, what: str) -> Any:
    if codec.size is not None and len(data) != codec.size:
        raise DecodeError(f"{what} has {codec.size} bytes, got {len(data)}")
    return codec.decode(data)
