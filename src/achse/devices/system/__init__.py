"""System service (port 10000): state of the whole station, its files, its routes.

Read `device` first. Each service has its module: `files` (with `folder` and `file_worker`),
`routes`, `registry`, `processes`, `time_service`, `target` and `diagnosis`.
"""

from achse.devices.system.device import StationControl, SystemDevice

__all__ = ["StationControl", "SystemDevice"]
