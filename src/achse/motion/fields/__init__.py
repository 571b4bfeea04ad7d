"""Fields of the axis record, part by part: each module declares the fields of one part of an axis.

A class of fields derives from the purpose of its fields: `Parameters`, `Inputs`, `States` or
`InternalFields` (`declare`). `achse.motion.record` puts the classes together; `often` has the order
of fields that each cycle uses.
"""
