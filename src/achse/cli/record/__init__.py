"""Commands that watch and record: `achse scope`, `monitor`, `replay`, `diff`.

`scope` samples values in the cycle of a station, `scope_picture` draws them. `monitor` shows and
records the packets between clients and devices; `replay` serves a recording, `diff` compares two.
"""
