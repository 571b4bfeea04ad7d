"""PLCs of a station: their declarations and code, and variables that are axes and channels.

Read `sources` first: a PLC from Python classes, Structured Text or a symbol file, and its online
change. `placed_structures` finds variables `AT %I` and `AT %Q` by their type; `axis_links` and
`channel_links` exchange them with the NC in each cycle.
"""
