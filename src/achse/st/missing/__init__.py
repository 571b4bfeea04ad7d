"""Missing names: what sources use and nothing declares, and stubs for it.

Read `libraries` (libraries that are not here, or lack a name), then `uses` (facts about one name),
`types` (missing types), `meanings` (of expressions) and `walk` (a walk through all units), then
`type_texts`, `library_names` and `stubs`.

A library that comes without sources leaves types, constants and variables that only their names
and uses are known of: `fbSend.bBusy` is a member, `fbSend(bExecute := TRUE)` has an input,
`E_Mode.Auto` is a value, `ARRAY [1..Lib.cMost]` takes a whole number.
"""
