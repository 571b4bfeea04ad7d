"""Parameters and states of an axis by name, with unit, range and meaning.

    await axis.parameters["max velocity"]                   # the value
    await axis.parameters["max velocity"].write(500.0)
    axis.parameters["max velocity"].unit                    # "mm/s"

Source: 002 §6.4.4.1 (0x4000 + id) and §6.4.4.2 (0x4100 + id).
"""

from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from achse.ams import DeviceError
from achse.ams.commands import ReadRequest
from achse.client.nc.errors import AxisRefused
from achse.client.nc.services import NcService, UnknownService, named, services
from achse.codes import ReturnCode

if TYPE_CHECKING:
    from achse.client.nc.access import AxisAccess
    from achse.client.target import Target


class AxisValue:
    """One parameter or state of an axis: await it for its value, or `read` and `write` it."""

    def __init__(self, axis: "AxisAccess", service: NcService, element: int = 0) -> None:
        service.place(0, element)
        self._axis = axis
        self.service = service
        self.element = element

    @property
    def name(self) -> str:
        return self.service.name

    @property
    def unit(self) -> str:
        """The unit; says mm until the axis was asked for its `unit`."""
        return self.service.unit_of(self._axis.known_unit)

    @property
    def range(self) -> str:
        """Range that may be written, as `0..1000`, `0..` or `0=OFF, 1=ON`; empty without a
        limit."""
        if self.service.choices is not None:
            return ", ".join(f"{each.value}={each.name}" for each in self.service.choices)
        return self.service.range

    @property
    def description(self) -> str:
        """Meaning of the parameter."""
        return self.service.description

    @property
    def writable(self) -> bool:
        return self.service.writable

    def __repr__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        range = f" {self.range}" if self.writable and self.range else ""
        return f"<{self._axis} {self.name}{unit}{range}: {self.description}>"

    def __await__(self) -> Generator[Any, None, Any]:
        return self.read().__await__()

    async def read(self) -> Any:
        """Return the value; a member of its enumeration where it has one. Raises AxisRefused."""
        return self.decoded(await self._axis.request(self.service, self._request, self.element))

    async def _request(self, nc: "Target", place: tuple[int, int]) -> bytes:
        """Return the bytes; an older NC knows the shorter layout of a structure only."""
        newest, *older = reversed(self.service.layouts)
        try:
            return await nc.read_raw(*place, newest.size)
        except DeviceError as refusal:
            if refusal.code != ReturnCode.INVALID_SIZE.number or not older:
                raise
        return await nc.read_raw(*place, older[0].size)

    def decoded(self, data: bytes) -> Any:
        """Return the value that `data` is."""
        layouts = self.service.layouts
        layout = next((each for each in layouts if each.size == len(data)), layouts[-1])
        value = layout.decode(data)
        choices = self.service.choices
        if choices is not None and value in choices.__members__.values():
            return choices(value)
        return value

    async def write(self, value: Any) -> None:
        """Set it: a number, or the name of a choice.

        Raises ValueError for what is not a number of its kind, AxisRefused if the NC refuses it.
        """
        if not self.writable:
            raise ValueError(f"{self.name} is for reading only")
        choices = self.service.choices
        if isinstance(value, str) and choices is not None:
            key = value.strip().upper().replace(" ", "_")
            if key not in choices.__members__:
                raise ValueError(f"{self.name}: expected {self.range}, got {value!r}")
            value = choices[key]
        try:
            data = self.service.layout.encode(value)
        except ValueError as error:
            raise ValueError(f"{self.name}: {error}") from None
        try:
            await self._axis.request(
                self.service, lambda nc, place: nc.write_raw(*place, data), self.element
            )
        except AxisRefused as refusal:
            expected = f"{self.name} = {value!r}, expected {self.range} {self.unit}".rstrip()
            context = expected if self.range else refusal.context
            raise AxisRefused(refusal.code, refusal.axis, context) from refusal


class AxisValues:
    """The parameters, or the states, of an axis by name; sub-element 0 unless `element` says so."""

    def __init__(
        self,
        axis: "AxisAccess",
        groups: Sequence[int],
        element: int = 0,
    ) -> None:
        self._axis = axis
        self._groups = groups
        self._element = element

    def element(self, number: int) -> "AxisValues":
        """Return the parameters of encoder, controller and drive `number` of the axis, from 0."""
        if not 0 <= number <= 8:
            raise ValueError(f"element: expected 0..8, got {number!r}")
        return AxisValues(self._axis, self._groups, number)

    def __getitem__(self, name: str) -> AxisValue:
        """Return a parameter by name. Raises UnknownService (a LookupError) with what is near."""
        service = named(self._groups, name)
        if not service.readable:
            raise UnknownService(f"{service.name} cannot be read")
        return AxisValue(self._axis, service, self._element)

    def __contains__(self, name: object) -> bool:
        try:
            self[str(name)]
        except LookupError:
            return False
        return True

    def __iter__(self) -> Iterator[AxisValue]:
        """Iterate over the parameters with a single value; structures repeat these values. For a
        sub-element: only the parameters that it has."""
        of_axis = not self._element
        every: dict[str, NcService] = {}
        for group in reversed(self._groups):
            every |= services()[group]
        for service in every.values():
            if service.readable and service.single and (of_axis or service.of_element):
                yield AxisValue(self._axis, service, self._element)

    async def read(self) -> dict[str, Any]:
        """Return all of them by name, in sum commands; what this axis does not have is left out."""
        nc, axis_id = await self._axis.located()
        every = list(self)
        wanted = [
            ReadRequest(*each.service.place(axis_id, self._element), each.service.layout.size)
            for each in every
        ]
        values: dict[str, Any] = {}
        for each, outcome in zip(every, await nc.send_each(wanted), strict=True):
            if outcome.result == 0:
                values[each.name] = each.decoded(outcome.data)
        return values
