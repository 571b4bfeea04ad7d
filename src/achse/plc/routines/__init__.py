"""Routines without a cycle of their own: built-in functions, Python bodies, calls from outside.

Read `builtins` (library routines in Python) and `builtin_memory` (what they see of their PLC), then
`python_bodies` and `routine_calls`. `json_documents` holds what the JSON library works on.
"""
