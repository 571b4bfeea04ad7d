"""Debugging over ADS: a group of the station's own service, by which any client stops a PLC.

A request is a JSON object with `do`; so is the answer, `{"error": …}` for what cannot be done. The
index offset is the AMS port of the PLC, 0 for the first one. Read gives the state.
"""

from typing import TYPE_CHECKING

from achse.server import RawGroup

if TYPE_CHECKING:
    from achse.devices.debug_service import Attached, DebuggedStation, DebugService

DEBUG = 0xFA05
"""Index group."""


def debug_group(station: "DebuggedStation", attached: "Attached") -> RawGroup:
    """Return the service by which PLCs are debugged. It is loaded at the first request.

    `attached` is called with a client that wants debugging to end with its connection.
    """
    services: list[DebugService] = []

    def service() -> "DebugService":
        if not services:
            from achse.devices.debug_service import DebugService

            services.append(DebugService(station, attached))
        return services[0]

    return RawGroup(
        DEBUG,
        "debugging",
        read=lambda offset, length, client: service().state(offset),
        read_write=lambda offset, length, data, client: service().answer(offset, data, client),
        last_offset=0xFFFF,
        request='JSON: {"do": "break", "path": …, "line": …}, clear, breaks, attach, exceptions,'
        " go, step, pause, calls, variables, evaluate, set, source, files, end",
        response="JSON: the result, or the error; Read: the state",
        description="Offset = AMS port of a PLC (0: the first). Breakpoints, steps, calls and"
        " variables; a halted cycle blocks the PLC, not the station.",
        source="achse",
    )
