"""Plans without cycles: commands on one axis, each planned and judged in machine code.

Read `chain` first, the commands that are drawn for an axis; `judge` integrates what was planned,
`kernel` does both, `player` plays the chains of a seed.
"""
