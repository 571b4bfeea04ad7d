"""Structured Text: sources in, declarations as IEC types and checked bodies out. Nothing runs here.

Read `lexis` (texts, tokens, pragmas), `syntax` (the tree and its parser; `graphical` reads bodies
that are drawn), `values` (what constants are worth), `declared` (names and types), `files` (folders
and project files). `declare` and `project` put them together, `reach` says what of it a task
reaches, `check` finds faults and gives the form in `typed` that programs are made from.
"""
