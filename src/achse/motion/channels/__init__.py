"""Channels: the owners of groups. One with an interpreter runs part programs on its 3D group.

Read `channel` and `program_channel` (states in `states` and `program_states`) first. `feeder` gives
the moves of a program to the group (`program_path` translates them, `planned_path` runs ahead for a
block search), `technology` has the M, H, S and T functions for the PLC, `program_fault` the errors
with their place. `store` and `files` keep programs and tools; `table` makes the channels of an NC
from their `parameters`.

Source: 002 §6.4.2.
"""
