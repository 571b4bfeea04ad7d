"""Commands that watch and record: `achse scope`, `monitor`, `record`, `replay`, `diff`.

`scope` samples values in the cycle of a station, `scope_picture` draws them. `monitor` shows the
packets between clients and devices; `record` keeps them, serves them again and compares them.
"""
