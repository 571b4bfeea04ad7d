"""Stops and their lock, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import NO_DATA, request
from achse.motion import commands

__all__ = ["STOPS"]

_RAMP = request(deceleration="d", jerk="d")
_ORIENTED = request(modulo_end_position="d", deceleration="d", jerk="d")

STOPS = (
    function(0x02, "stop", commands.stop, NO_DATA, "stop with the running deceleration"),
    function(0x03, "clear", commands.clear, NO_DATA, "take the job and waiting commands away"),
    function(0x04, "emergency_stop", commands.emergency_stop, _RAMP, "stop, not weaker than now"),
    function(0x05, "parameterized_stop", commands.parameterized_stop, _RAMP, "stop by a ramp"),
    function(0x09, "oriented_stop", commands.oriented_stop, _ORIENTED, "stop at a modulo position"),
    function(0x18, "release_motion_lock", commands.release_lock, NO_DATA, "end 'stop and lock'"),
)
