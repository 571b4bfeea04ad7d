"""The camshaft controllers, AMS port 900.

Read `device` first; `rows` are its services, `served` a controller as they show it.
"""

from achse.devices.camshaft.device import CAMSHAFT_PORT, CamshaftDevice
from achse.devices.camshaft.served import ServedCamshaft

__all__ = ["CAMSHAFT_PORT", "CamshaftDevice", "ServedCamshaft"]
