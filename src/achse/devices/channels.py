"""Channels of virtual slaves by ADS: inputs are set and outputs read by the names of their ESI.

Beside the EtherCAT master, which knows nothing of it. Texts are JSON.
"""

import json
from collections.abc import Callable
from typing import Any

from achse.ethercat import Segment
from achse.ethercat.virtual import VirtualDevice
from achse.ethercat.virtual.channels import Value
from achse.server import RawGroup

CHANNELS = 0xFA08
"""Index group."""

_KNOWN_FIELDS = {"slave", "channel", "value"}


def channels_group(segment: Callable[[], Segment]) -> RawGroup:
    """Return the index group of the virtual slaves of a segment."""
    return RawGroup(
        CHANNELS,
        "channels",
        read=lambda offset, length, client: _json(_states(segment())),
        read_write=lambda offset, length, data, client: _access(segment(), data),
        request="JSON: slave (1 …), channel, value to set an input",
        response="JSON: a table for each channel; the value it has now, or the error",
        description="Channels of virtual slaves made from ESI files, by name.",
        source="achse",
    )


def _states(segment: Segment) -> list[dict[str, Any]]:
    """Return the present value of each channel."""
    rows: list[dict[str, Any]] = []
    for number, slave in enumerate(segment.slaves, 1):
        device = slave.application
        if not isinstance(device, VirtualDevice):
            continue
        whole = {channel.name: channel for channel in device.channels.values()}
        rows += [
            {
                "slave": number,
                "type": device.name,
                "state": slave.state.name,
                "channel": name,
                "output": channel.output,
                "value": _shown(device.output(name)),
            }
            for name, channel in whole.items()
        ]
    return rows


def _access(segment: Segment, data: bytes) -> bytes:
    try:
        request = json.loads(data.rstrip(b"\0"))
        if not isinstance(request, dict) or request.keys() - _KNOWN_FIELDS:
            raise ValueError(f"expected {', '.join(sorted(_KNOWN_FIELDS))}; got {request!r}")
        slaves = segment.slaves
        number = int(request.get("slave", 1))
        if not 1 <= number <= len(slaves):
            raise ValueError(f"there are {len(slaves)} slaves, got {number}")
        device = slaves[number - 1].application
        if not isinstance(device, VirtualDevice):
            raise ValueError(f"slave {number} is not made from an ESI file")
        name = str(request["channel"])
        if "value" in request:
            device.set_input(name, _value(request["value"]))
        return _json({"value": _shown(device.output(name))})
    except KeyError as missing:
        return _json({"error": str(missing.args[0])})
    except (TypeError, ValueError, OverflowError, RecursionError) as fault:
        return _json({"error": str(fault)})


def _value(value: object) -> Value:
    if isinstance(value, bool | int | float):
        return value
    if isinstance(value, str):
        return bytes.fromhex(value)
    raise ValueError(f"expected a number or hexadecimal bytes, got {value!r}")


def _shown(value: Value) -> bool | int | float | str:
    return value.hex() if isinstance(value, bytes) else value


def _json(document: Any) -> bytes:
    return json.dumps(document).encode()
