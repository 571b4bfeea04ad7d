"""The axis record, part by part: each module declares the fields of one part of an axis.

A class of fields derives from what its fields are for: `Parameters`, `Inputs`, `States` or
`Memory`. `achse.motion.record` puts the classes together.
"""
