"""DIN 66025 part programs: text → blocks → canonical commands. No axes, no clock, no ADS in here.

`program` holds a text, `interpreter` runs it and yields the commands of `canon`, which a channel
carries out; `tool_table` and `offsets` hold what the machine adds.
"""
