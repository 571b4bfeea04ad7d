"""The NC device: service tables over the axes of `achse.motion`."""

from achse.devices.nc.device import NcDevice

__all__ = ["NcDevice"]
