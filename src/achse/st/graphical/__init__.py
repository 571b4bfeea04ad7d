"""Graphical bodies: networks (LD, FBD, IL), sequential function charts, continuous function charts.

A body is read from its `archive` into a tree and lowered to the statements that Structured Text
has, so that checker, debugger, online change and both emitters serve it. Read `body` first, then
`networks` and `network_lowering`.

Source: public TwinCAT 3 projects and the vendor's manuals; each choice is named in
`docs/coverage/graphical-bodies.md`.
"""
