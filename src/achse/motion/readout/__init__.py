"""Readout of an axis: values for clients and the PLC that no cycle needs.

`shown` has the values that are computed when they are read, `shown_values` the same in machine code
for those that are sampled, `cyclic_image` the structure that a PLC gets in each of its cycles.
"""
