"""Commands that begin other generators of set points than moves.

`generators` has what they share. `external` begins external set points, `oscillation` reversing,
velocity steps and sine, `open_loop` direct outputs and torque, `special` a move that has a second
velocity from a position on.
"""
