"""The scope server of a station: its phase in the cycle, its views, and scopes for Python."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from achse.ams import DeviceError
from achse.devices.scope import ScopeDevice, ScopeServer
from achse.devices.scope.channels import ScopeChannels
from achse.devices.scope.scopes import NumberedScope
from achse.devices.system import SystemDevice
from achse.scope import (
    ScopeChannel,
    ScopeData,
    ScopeError,
    ScopeState,
    ScopeTrigger,
    definition_of,
)
from achse.scope.service import SCOPE_PORT
from achse.station.building.building import Building
from achse.station.clocks.cycle import Phase, PhasePlace
from achse.station.configuration.types import ConfigError

_NC_PORT = 500


class ScopePhase(Phase):
    """Samples of all scopes, after everything else of a cycle."""

    place, name = PhasePlace.SCOPE, "scope"

    def __init__(self, scopes: ScopeServer) -> None:
        self._scopes = scopes

    @property
    def due_ns(self) -> float:
        """Station time at which the next sample of any scope is due."""
        return self._scopes.due_ns

    def step(self, now_ns: int) -> None:
        """Take all samples that are due."""
        self._scopes.sample(now_ns)


def make_scope(building: Building) -> None:
    """Make the scope server with the views of the configuration. Raises ConfigError."""
    ground = building.ground
    config = ground.config.scope
    tick_ns = building.tick_ns
    port = next(iter(building.plcs), _NC_PORT)
    channels = ScopeChannels(lambda: building.devices, port)
    scopes = ScopeServer(
        channels,
        lambda: ground.clock.time_ns,
        limits=config.limits(),
        tick_ns=tick_ns,
        compiled=ground.config.nc.code != "plain",
    )
    for plc in building.plcs.values():
        plc.on_online_change(scopes.find_again)
    device = ScopeDevice(
        scopes, clock=ground.clock, epoch_at=ground.clock.epoch_at, folder=_folder(building)
    )
    systems = [each for each in building.devices if isinstance(each, SystemDevice)]
    if systems:
        device.worker = lambda: systems[0].files.worker
    building.add_phase(ScopePhase(scopes))
    building.attach(device, SCOPE_PORT)
    for number, view in enumerate(config.view, 1):
        try:
            if number == 1:
                scopes.load(number, view.definition())
            else:
                scopes.add(view.definition())
            if view.start:
                scopes.start(scopes[number])
        except (ScopeError, DeviceError) as fault:
            raise ConfigError(f"scope.view[{number}]: {fault}") from None


def _folder(building: Building) -> Path | None:
    name = building.ground.config.scope.folder
    if name is None:
        return None
    folder = building.ground.base / name
    if not folder.is_dir():
        raise ConfigError(f"scope.folder: expected a folder, got {str(folder)!r}")
    if building.ground.base.resolve().is_relative_to(folder.resolve()):
        raise ConfigError(
            f"scope.folder: expected a folder for recordings, {str(folder)!r} has the station.toml"
        )
    return folder


class StationScope:
    """A scope for Python code beside the station: what it records is there as NumPy arrays.

    Use it in a `with` block, or `close` it.
    """

    def __init__(self, device: ScopeDevice, scope: NumberedScope) -> None:
        self._device = device
        self._scopes = device.scopes
        self._scope = scope

    @classmethod
    def of(
        cls,
        device: ScopeDevice,
        channels: str | ScopeChannel | Iterable[str | ScopeChannel | dict[str, Any]],
        *,
        length: float,
        triggers: str | ScopeTrigger | Iterable[str | ScopeTrigger],
        pretrigger: float,
        combine: str,
        name: str,
    ) -> "StationScope":
        """Return a scope that is offline; see `Station.scope`. Raises ScopeError."""
        each = [channels] if isinstance(channels, str | ScopeChannel) else list(channels)
        definition = definition_of(
            {
                "name": name,
                "channels": each,
                "record_length": length,
                "triggers": [triggers]
                if isinstance(triggers, str | ScopeTrigger)
                else list(triggers),
                "pretrigger": pretrigger,
                "combine": combine,
            }
        )
        return cls(device, device.scopes.add(definition))

    @property
    def number(self) -> int:
        """Its number, by which clients find it."""
        return self._scope.number

    @property
    def state(self) -> ScopeState:
        """State of the recorder."""
        return self._scope.recorder.state

    @property
    def trigger_time(self) -> float | None:
        """Station time of the trigger, s."""
        trigger_ns = self._scope.recorder.trigger_ns
        return None if trigger_ns is None else trigger_ns / 1e9

    @property
    def lost(self) -> dict[str, str]:
        """Channels that end early, with the reason."""
        groups: Sequence[Any] = self._scope.recorder.groups
        return {
            each.channel.name: each.failure
            for group in groups
            for each in group.channels
            if each.failure
        }

    def start(self) -> None:
        """Record from the next cycle on. Raises ScopeError, DeviceError beyond the limits."""
        self._scopes.start(self._scope)

    def stop(self) -> None:
        """Record no more; what there is stays."""
        self._scopes.stop(self._scope)

    def trigger(self) -> None:
        """Trigger the scope now. Raises DeviceError unless it waits for the trigger."""
        self._scopes.trigger(self._scope)

    def data(self) -> ScopeData:
        """Return a copy of what there is."""
        return self._scope.recorder.data(self._device.epoch_of(self._scope))

    def _repr_html_(self) -> str:
        """Return the HTML for a notebook: the data recorded so far."""
        return self.data()._repr_html_()

    def close(self) -> None:
        """End it, with what it has recorded. Twice is not an error."""
        if any(each is self._scope for each in self._scopes):
            self._scopes.close(self._scope)

    def __enter__(self) -> "StationScope":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
