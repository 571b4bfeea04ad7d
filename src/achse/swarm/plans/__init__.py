"""Plans without cycles: commands on one axis, each planned and checked in machine code.

Read `chain` first, the commands that are drawn for an axis; `check` integrates the plans,
`kernel` does both, `player` plays the chains of a seed.
"""
