"""Motion profiles: the mathematics of segments of constant jerk, without an axis.

Read `segments` first (a profile is written and walked), then `ramps` (from a velocity to another),
then `profile` (to a position or a velocity from any state). All is kernel source: plain functions
on numbers, which axes, paths and channels use alike.
"""
