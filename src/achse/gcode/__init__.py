"""DIN 66025 part programs: text → blocks → canonical commands. No axes, no clock, no ADS in here.

`canon` holds the commands that a channel carries out, `errors` what is wrong with a program. Read
`text` (lines, words, formulas), `state` (what the channel keeps: modal groups, R parameters, zero
shifts, tools), `geometry` (arcs, contours, cutter compensation) and then `interpretation`, which
runs a program block by block.
"""
