"""Commands that move axes: `achse axis`, `achse table`, `achse camshaft`.

Read `nc` first, the axes that a command names; then `axis`, the commands of one axis, and `move`,
which follows a command to its end. `home`, `excite` with `excitation`, and `gear` are other ways of
motion; `parameters` reads and sets the rows of an axis. `trace` and `watch` draw its motion.
`table` with `table_curve` and `table_files` is about cam tables, `camshaft` about cam controllers.
"""
