"""Do with pyads what Home Assistant's ADS integration does with a configuration.yaml."""

import argparse
import ctypes
import queue
import struct
from pathlib import Path
from typing import Any

import pyads
import yaml

FORMATS = {
    "bool": "<?", "byte": "<B", "int": "<h", "uint": "<H", "dint": "<i", "udint": "<I",
    "real": "<f", "lreal": "<d", "sint": "<b", "usint": "<B", "word": "<H", "dword": "<I",
}  # fmt: skip
"""The types of `adstype`, as they travel."""


def entities(configuration: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """Platform, name, variable and type of each sensor and switch."""
    return [
        (platform, one["name"], one["adsvar"], one.get("adstype", "bool"))
        for platform in ("sensor", "binary_sensor", "switch")
        for one in configuration.get(platform, [])
        if one["platform"] == "ads"
    ]


def shown(adstype: str, data: bytes) -> str:
    (value,) = struct.unpack(FORMATS[adstype], data)
    if adstype == "bool":
        return "on" if value else "off"
    return f"{value:g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--file", type=Path, default=Path(__file__).with_name("configuration.yaml"))
    parser.add_argument("--turn", nargs=2, metavar=("SWITCH", "on|off"), default=None)
    parser.add_argument("--host", help="instead of ip_address and device of the file")
    parser.add_argument("--seconds", type=float, default=1.0, help="how long to wait for values")
    arguments = parser.parse_args()

    configuration = yaml.safe_load(arguments.file.read_text(encoding="utf-8"))
    hub = configuration["ads"]
    host = arguments.host or hub.get("ip_address")
    device = f"{arguments.host}.1.1" if arguments.host else hub["device"]

    came: queue.Queue[tuple[int, bytes]] = queue.Queue()

    def sample(notification: Any, name: str) -> None:
        contents = notification.contents
        behind = pyads.structs.SAdsNotificationHeader.data.offset
        address = ctypes.addressof(contents) + behind
        came.put((int(contents.hNotification), ctypes.string_at(address, contents.cbSampleSize)))

    with pyads.Connection(device, hub["port"], host) as plc:
        every = entities(configuration)
        handles: dict[int, tuple[str, str, str]] = {}
        subscribed = []
        for platform, name, variable, adstype in every:
            attributes = pyads.NotificationAttrib(struct.calcsize(FORMATS[adstype]))
            handle, user = plc.add_device_notification(variable, attributes, sample)
            handles[handle] = platform, name, adstype
            subscribed.append((handle, user))
        if arguments.turn:
            wanted, to = arguments.turn
            variable = next(one[2] for one in every if one[:2] == ("switch", wanted))
            plc.write_by_name(variable, to == "on", pyads.PLCTYPE_BOOL)
        try:
            while True:
                handle, raw = came.get(timeout=arguments.seconds)
                platform, name, adstype = handles[handle]
                print(f"{platform} {name} = {shown(adstype, raw)}", flush=True)
        except queue.Empty:
            pass
        for handle, user in subscribed:
            plc.del_device_notification(handle, user)


if __name__ == "__main__":
    main()
