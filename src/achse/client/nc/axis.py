"""One axis of an NC: enabled, moved, watched and set by name, ours and real ones alike.

Documented services are used (002 §6.4.4): functions at 0x4200 + id, parameters at 0x4000 + id,
states at 0x4100 + id, the cyclic interface at 0x4300 + id. On a controller whose PLC is linked to
the axis, that PLC writes the cyclic interface in each of its cycles: there the PLC enables, as with
MC_Power, and `enable` says so (`AxisDisabled`).
"""

from collections.abc import Callable, Iterable
from typing import Literal

from achse.ams import AdsError
from achse.ams.commands import WriteRequest
from achse.client.nc.access import SAMPLE_TIME
from achse.client.nc.arguments import buffer_mode, choice, real, seconds
from achse.client.nc.couplings import AxisCouplings
from achse.client.nc.errors import AxisDisabled, AxisRefused, AxisTimeout
from achse.client.nc.moves import (
    CommandCompletion,
    Completion,
    EnableCompletion,
    HomingCompletion,
    StandstillCompletion,
)
from achse.client.nc.services import CYCLIC, named
from achse.client.nc.status import AxisStatus
from achse.codes.axis import ActualPositionType, BufferMode, ControlBit, JogType, StartType
from achse.codes.station import MISSING_CONDITION, SERVICE_PORT

Direction = Literal["+", "-"]
ModuloWay = Literal["shortest", "+", "-"]
JogSpeed = Literal["slow", "fast", "rapid"]

ENABLED_WITHIN = 10.0
"""Seconds of the controller's time that enabling, disabling and resetting may take."""

PLC_WRITES_WITHIN = 0.5
"""Seconds after which the enables are checked again."""

_LONGEST_CONDITION = 1000
"""Bytes of the text that says what a drive misses."""

_NUMBERS = (
    "position", "velocity", "acceleration", "deceleration", "jerk",
    "blending_position", "start_velocity", "end_velocity",
)  # fmt: skip
"""Names of the numbers of a universal start, as the methods have them."""

_ENABLES = {
    "controller_enable": ControlBit.ENABLE,
    "feed_enable_plus": ControlBit.FEED_ENABLE_PLUS,
    "feed_enable_minus": ControlBit.FEED_ENABLE_MINUS,
}
"""Services of the bits that enable, and the bits."""

_MODULO = {
    "shortest": StartType.MODULO_SHORTEST,
    "+": StartType.MODULO_POSITIVE,
    "-": StartType.MODULO_NEGATIVE,
}
_JOGS = {"slow": JogType.SLOW, "fast": JogType.FAST, "rapid": JogType.RAPID}
_SIGNS = {"+": 0, "-": 1}
"""A jog type is one more to smaller positions."""


class Move:
    """A command that the NC accepted: its number, and how to wait for its end."""

    def __init__(
        self, axis: "RemoteAxis", number: int | None, completion: Callable[[], Completion]
    ) -> None:
        self.axis = axis
        self.number = number
        """The NC's number of the command; None for those that have none (homing, plain stops)."""
        self.status: AxisStatus | None = None
        """The sample that showed its end, None until `finished` has seen it."""
        self.completion = completion
        """Factory of the completion that checks its samples."""

    def __repr__(self) -> str:
        end = "" if self.status is None else f", ended at {self.status.position:.10g}"
        return f"<Move {self.number} of {self.axis}{end}>"

    async def finished(
        self, within: float | None = None, patience: float | None = None
    ) -> AxisStatus:
        """Wait until it is done; gives the sample that showed it.

        `within` is in seconds of the controller's time, `patience` of this computer's. Raises
        `AxisFailed`, `AxisAborted`, `AxisDisabled`, `AxisTimeout`, `ConnectionLost`,
        `RequestTimeout`. The axis goes on after a time-out, and when the wait is cancelled.
        """
        if self.status is None:
            self.status = await self.axis.follow(self.completion(), "its command", within, patience)
        return self.status


class RemoteAxis(AxisCouplings):
    """An axis of an NC and what it can be asked to do.

    All methods raise `AxisError` for what the axis or the NC says, other `AdsError` for what is
    between; values that are not numbers are ValueErrors and are not sent. 0 for acceleration,
    deceleration or jerk means that of the axis. Units are those of the axis, and seconds.
    Where a method waits, `within` limits it in seconds of the controller's time and `patience` in
    seconds of this computer's; the axis goes on after a time-out and when the wait is cancelled.
    """

    # switches ----------------------------------------------------------------------------------

    async def enable(
        self,
        *,
        positive: bool = True,
        negative: bool = True,
        override: float | None = 100.0,
        within: float = ENABLED_WITHIN,
    ) -> None:
        """Enable the controller and the feed, set the override (%), wait until it is ready.

        `override` None leaves it as it is. Raises `AxisFailed` for an axis in error, `AxisDisabled`
        when another program takes the enables away: on a controller whose PLC is linked to the
        axis, enable there. `AxisTimeout` when the axis does not get ready; of an achse
        station it names the condition that its drive misses.
        """
        limit = seconds("within", within)
        if override is not None:
            await self.set_override(override)
        wanted = (True, positive, negative)
        await self._switch(wanted)
        try:
            while True:
                limit_now = PLC_WRITES_WITHIN if limit is None else min(limit, PLC_WRITES_WITHIN)
                try:
                    await self.follow(
                        EnableCompletion(str(self)), "being ready for operation", limit_now
                    )
                    await self._check_enables(wanted)
                    return
                except AxisTimeout:
                    await self._check_enables(wanted)
                    if limit is not None:
                        limit -= limit_now
                        if limit <= 0:
                            raise
        except AxisTimeout as late:
            message = f"not ready for operation after {within:g} s"
            why = await self._missing_condition()
            raise AxisTimeout(0, str(self), f"{message}: {why}" if why else message) from late

    async def _missing_condition(self) -> str:
        """Return the reason why the drive is not ready, from an achse station; else empty."""
        nc, axis_id = await self.located()
        station = nc.at_port(SERVICE_PORT)
        try:
            text = await station.read_raw(MISSING_CONDITION, axis_id, _LONGEST_CONDITION)
        except AdsError:
            return ""
        return text.rstrip(b"\0").decode("utf-8", "replace")

    async def disable(self, *, within: float = ENABLED_WITHIN) -> None:
        """Take the enables away, and wait until the axis is disabled."""
        seconds("within", within)  # before anything is switched
        await self._switch((False, False, False))
        await self.wait_for("disabled", within=within)

    async def _switch(self, enables: Iterable[bool]) -> None:
        """Switch one bit by its own service, so that clients keep each other's other bits."""
        nc, axis_id = await self.located()
        parts = []
        for name, on in zip(_ENABLES, enables, strict=True):
            service = named((CYCLIC,), name)
            parts.append(WriteRequest(*service.place(axis_id), service.layout.encode(int(on))))
        for outcome in await nc.send_each(parts):
            if outcome.result:
                raise AxisRefused(outcome.result, str(self), "enables")

    async def _check_enables(self, wanted: Iterable[bool]) -> None:
        service = named((CYCLIC,), "control_dword")
        data = await self.request(service, lambda nc, at: nc.read_raw(*at, service.layout.size))
        word = int(service.layout.decode(data))
        missing = [
            bit for bit, on in zip(_ENABLES.values(), wanted, strict=True) if on and not word & bit
        ]
        if missing:
            raise AxisDisabled(
                0,
                str(self),
                "another program takes its enables away (ControlDWord is"
                f" 0x{word:X}); where a PLC is linked to the axis, enable it there, as by MC_Power",
            )

    async def reset(self, *, within: float = ENABLED_WITHIN) -> None:
        """Acknowledge errors, and wait until the axis has none. AxisFailed if it keeps one."""
        seconds("within", within)
        await self.call("reset")
        try:
            await self.wait_for(lambda status: not status.failed, within=within)
        except AxisTimeout:
            failure = await self.error()
            if failure is not None:
                raise failure from None

    # moves -------------------------------------------------------------------------------------

    async def move_to(
        self,
        position: float,
        *,
        velocity: float,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        modulo: ModuloWay | None = None,
        buffer: BufferMode | str = BufferMode.ABORTING,
        blending_position: float = 0.0,
        start_velocity: float = 0.0,
        end_velocity: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move to a position, and wait until the axis is there.

        `modulo` takes the position within the modulo period, reached that way. `buffer` says how
        the command follows a running one, as `"buffered"` or `"blending low"`; with `wait` False
        the move comes back as soon as it is accepted, so that others can follow it. Time limits
        and errors as `Move.finished`.
        """
        kind = StartType.ABSOLUTE
        if modulo is not None:
            kind = choice("modulo", modulo, _MODULO)
        return await self._start(
            kind, position, velocity, (acceleration, deceleration, jerk), buffer,
            (blending_position, start_velocity, end_velocity), wait, within, patience,
        )  # fmt: skip

    async def move_by(
        self,
        distance: float,
        *,
        velocity: float,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        buffer: BufferMode | str = BufferMode.ABORTING,
        blending_position: float = 0.0,
        start_velocity: float = 0.0,
        end_velocity: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move by a distance from the set position, or from where the command before ends."""
        return await self._start(
            StartType.RELATIVE, distance, velocity, (acceleration, deceleration, jerk), buffer,
            (blending_position, start_velocity, end_velocity), wait, within, patience,
        )  # fmt: skip

    async def move_velocity(
        self,
        velocity: float,
        *,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        buffer: BufferMode | str = BufferMode.ABORTING,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move on and on, backwards if `velocity` is negative, and wait until it has its velocity.

        The axis goes on until `halt`, `stop` or another move.
        """
        speed = real("velocity", velocity)
        if speed == 0.0:
            raise ValueError("velocity: expected one that is not 0; `halt` brings the axis to rest")
        kind = StartType.ENDLESS_NEGATIVE if speed < 0.0 else StartType.ENDLESS_POSITIVE
        return await self._start(
            kind, 0.0, abs(speed), (acceleration, deceleration, jerk), buffer,
            (0.0, 0.0, 0.0), wait, within, patience,
        )  # fmt: skip

    async def halt(
        self,
        *,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Bring the axis to rest; another move may take over meanwhile."""
        return await self._start(
            StartType.HALT, 0.0, 0.0, (0.0, deceleration, jerk), BufferMode.ABORTING,
            (0.0, 0.0, 0.0), wait, within, patience,
        )  # fmt: skip

    async def stop(
        self,
        *,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        lock: bool = False,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Stop the axis, by the ramp of the running command unless a ramp is given.

        With `lock` no command moves it until `release`. A ramp has both values.
        """
        if lock:
            return await self._start(
                StartType.STOP_AND_LOCK, 0.0, 0.0, (0.0, deceleration, jerk), BufferMode.ABORTING,
                (0.0, 0.0, 0.0), wait, within, patience,
            )  # fmt: skip
        seconds("within", within)
        seconds("patience", patience)
        ramp = real("deceleration", deceleration), real("jerk", jerk)
        if ramp == (0.0, 0.0):
            await self.call("stop")
        else:
            await self.call("parameterized_stop", *ramp)
        move = Move(self, None, lambda: StandstillCompletion(str(self)))
        return await self._followed(move, wait, within, patience)

    async def release(self) -> None:
        """End the lock of `stop(lock=True)`."""
        await self.call("release_motion_lock")

    async def home(
        self,
        *,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Home the axis as its reference mode says."""
        seconds("within", within)
        seconds("patience", patience)
        await self.call("home")
        move = Move(self, None, lambda: HomingCompletion(str(self)))
        return await self._followed(move, wait, within, patience)

    async def jog(
        self, direction: Direction, *, speed: JogSpeed = "slow", duration: float | None = None
    ) -> Move:
        """Move by hand, at the slow, fast or rapid velocity of the axis' parameters.

        With a `duration` (seconds of the controller's time) the key is let go after it: the axis
        is halted, and at rest afterwards. Without, it goes on until `halt`.
        """
        kind = choice("speed", speed, _JOGS) + choice("direction", direction, _SIGNS)
        limit = seconds("duration", duration)
        number = await self._universal(kind, 0.0, 0.0, (0.0, 0.0, 0.0), BufferMode.ABORTING)
        move = self._move(number, endless=True)
        if limit is None:
            return move
        try:
            await self._pass(limit, move)
        finally:
            await self.halt(wait=False)
        await self.wait_for("idle", patience=None)
        return move

    async def _pass(self, seconds: float, move: Move) -> None:
        completion = move.completion()
        async with self.trace(min(SAMPLE_TIME, max(seconds, 1e-3)), seconds) as samples:
            while (status := await samples.next()) is not None:
                completion.check(status)

    # positions and tables ----------------------------------------------------------------------

    async def set_position(
        self, position: float, *, relative: bool = False, moving: bool = False
    ) -> None:
        """Give the present position another value, or shift it by one; at rest unless `moving`."""
        kind = ActualPositionType.RELATIVE if relative else ActualPositionType.ABSOLUTE
        value = real("position", position)
        if moving:
            await self.call("set_actual_position_on_the_fly", kind, 0, value)
        else:
            await self.call("set_actual_position", kind, value)

    async def set_homed(self, homed: bool = True) -> None:
        """Say that the position refers to the machine, or that it does not."""
        await self.call("set_homed_flag", int(homed))

    # commands ----------------------------------------------------------------------------------

    async def _start(
        self,
        kind: StartType,
        position: float,
        velocity: float,
        dynamics: tuple[float, float, float],
        buffer: BufferMode | str,
        borders: tuple[float, float, float],
        wait: bool,
        within: float | None,
        patience: float | None,
    ) -> Move:
        """Universal start, and if wished the way to its end."""
        seconds("within", within)  # before anything moves
        seconds("patience", patience)
        mode = buffer_mode(buffer)
        number = await self._universal(kind, position, velocity, dynamics, mode, borders)
        move = self._move(
            number,
            endless=kind in (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE),
            stops=kind in (StartType.HALT, StartType.STOP_AND_LOCK),
            target=float(position) if kind is StartType.ABSOLUTE else None,
        )
        return await self._followed(move, wait, within, patience)

    async def _universal(
        self,
        kind: int,
        position: float,
        velocity: float,
        dynamics: tuple[float, float, float],
        mode: BufferMode,
        borders: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> int:
        """Return the number of the accepted command."""
        numbers = [
            real(name, value)
            for name, value in zip(_NUMBERS, (position, velocity, *dynamics, *borders), strict=True)
        ]
        number, _ = await self.call(
            "universal_axis_start", kind, 0, *numbers[:5], mode, *numbers[5:]
        )
        return int(number)

    def _move(
        self, number: int, endless: bool = False, stops: bool = False, target: float | None = None
    ) -> Move:
        def completion() -> Completion:
            return CommandCompletion(str(self), number, endless=endless, stops=stops, target=target)

        return Move(self, number, completion)

    async def _followed(
        self, move: Move, wait: bool, within: float | None, patience: float | None
    ) -> Move:
        if wait:
            await move.finished(within, patience)
        return move
