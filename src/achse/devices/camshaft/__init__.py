"""The camshaft controllers, AMS port 900."""

from achse.devices.camshaft.device import CAMSHAFT_PORT, CamshaftDevice
from achse.devices.camshaft.served import ServedCamshaft

__all__ = ["CAMSHAFT_PORT", "CamshaftDevice", "ServedCamshaft"]
