"""Services of a station in a world: camshaft, scope and rights are drawn, and watched.

`drawing` puts them into worlds; each other module looks after the invariant of one service.
"""
