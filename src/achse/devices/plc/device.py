"""The PLC device: states, areas and symbols of one PLC application on its AMS port."""

from collections.abc import Callable

from achse.ams import AdsState, AmsAddress, DeviceError, Frame
from achse.codes import ReturnCode
from achse.devices.plc.areas import area_groups
from achse.devices.plc.requests import PlcRequests
from achse.devices.plc.symbols import PlcSymbols
from achse.plc import PlcRuntime, PlcState, PlcStateError
from achse.server import (
    DIRECT_CODES_OF_A_PLC,
    READ,
    ClientLimits,
    Device,
    DeviceRouter,
    Group,
    Layout,
    Service,
)

NAME = "Plc30 App"
VERSION = (3, 1, 4024)

_ADS_STATES = {
    PlcState.RUN: AdsState.RUN,
    PlcState.STOP: AdsState.STOP,
    PlcState.EXCEPTION: AdsState.EXCEPTION,
}

_SYSTEM_STATE = (
    Service(
        0,
        "system state",
        READ,
        Layout("<HHHBBHBBHH"),
        "ADS state, device state, restart index, version, revision, build, platform, OS type,"
        " flags, reserved. The restart index counts the resets.",
        read=lambda device: (
            device.ads_state,
            device.device_state,
            device.plc.restarts & 0xFFFF,
            *VERSION,
            1,
            0,
            0,
            0,
        ),
    ),
)
"""Group 0xF0: all about the state in 16 bytes."""


class PlcDevice(Device):
    """A PLC application on port 851 (or 801, 852, …).

    Write Control takes RUN, STOP and RESET: the first two keep all variables, RESET initialises
    them, stops and ends abandoned handles. RUN after a program error is refused with 0x712 until a
    RESET. SAVE_CONFIG keeps persistent variables as they are, as FB_WritePersistentData does.
    `requests` are those of its programs to others, from the first of its ports.
    """

    def __init__(
        self,
        plc: PlcRuntime,
        *,
        clock: Callable[[], int],
        limits: ClientLimits | None = None,
        requests: PlcRequests | None = None,
    ) -> None:
        self.plc = plc
        self.program_requests = requests
        self._restarts = plc.restarts
        symbols = PlcSymbols(plc)
        plc.on_online_change(symbols.refresh)
        super().__init__(
            NAME,
            VERSION,
            (*area_groups(plc.memory), Group(0xF0, _SYSTEM_STATE, self)),
            symbols,
            clock=clock,
            task_cycle_ns=plc.tasks[0].cycle_ns,
            ads_state=_ADS_STATES[plc.state],
            direct_codes=DIRECT_CODES_OF_A_PLC,
            limits=limits,
        )
        plc.on_state(self._show_state)
        plc.on_online_change(self.symbols_changed)

    def attach(self, router: DeviceRouter, port: int) -> AmsAddress:
        """Answer on `port`, and send requests from the first one. Raises RouterError."""
        address = super().attach(router, port)
        if self.program_requests is not None:
            self.program_requests.indications.connect(self._reply)
        if self.program_requests is not None and len(self.addresses) == 1:
            self.program_requests.connect(router, address)
        return address

    def deliver(self, frame: Frame) -> bool:
        """Answer a request, or take the answer to one of the programs."""
        if frame.flags & 1 and self.program_requests is not None:
            self.program_requests.receive(frame)
            return True
        if self.program_requests is not None and self._is_for_programs(frame):
            return True
        return super().deliver(frame)

    def _is_for_programs(self, frame: Frame) -> bool:
        """Return True if a program accepted the request; a PLC that is not in RUN accepts none."""
        bodies = self.plc.bodies
        if self.program_requests is None or bodies is None or self.plc.state is not PlcState.RUN:
            return False
        return self.program_requests.indications.take(frame, bodies.project.routines.__contains__)

    def _show_state(self, state: PlcState) -> None:
        self.ads_state = _ADS_STATES[state]
        if self._restarts != self.plc.restarts:
            self._restarts = self.plc.restarts
            self.end_abandoned()
        if state is not PlcState.RUN and self.program_requests is not None:
            self.program_requests.indications.forget()

    def task_cycle(self, context: int) -> int:
        """Cycle of task number `context`; of the first one if there is no such task."""
        tasks = self.plc.tasks
        return tasks[context - 1 if 0 < context <= len(tasks) else 0].cycle_ns

    def write_control(self, ads_state: int, device_state: int, data: bytes) -> None:
        """Run, stop or reset the PLC, or keep its persistent variables (SAVE_CONFIG; 0x700 if they
        cannot be written); any other state is refused with 0x712."""
        try:
            if ads_state == AdsState.RUN:
                self.plc.run()
            elif ads_state == AdsState.STOP:
                self.plc.stop()
            elif ads_state == AdsState.RESET:
                self.plc.reset()
            elif ads_state == AdsState.SAVE_CONFIG:
                if not self.plc.keep_persistent():
                    raise DeviceError(
                        ReturnCode.DEVICE_ERROR, "persistent variables cannot be written"
                    )
            else:
                raise PlcStateError(f"a PLC does not go to {AdsState(ads_state).name}")
        except PlcStateError as failure:
            raise DeviceError(ReturnCode.INVALID_STATE, str(failure)) from None
