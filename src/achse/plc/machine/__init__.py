"""Machine code of programs: the typed form of Structured Text through the back end of LLVM.

It works on the bytes that are the symbols, and leaves the same bytes as the plain code of
`achse.plc.code` after every cycle. `ProjectTranslator` makes a module of a typed project,
`MachineProgram` is that module in the memory of a PLC; `machine_program` does both, with a cache.

What stays plain: routines that Python does, and those with something in them that is not
translated (`NotTranslatedError` says what). Both kinds call each other by entries and callbacks.

A routine is a function of its instance and its parameters (`signatures`). It knows where each area
is (`storages`); an address of the PLC is looked up in the table of areas before it is used, so
that nothing but PLC memory is ever reached. What may go wrong has a place (`fault_places`): its
number is that of the fault, and says routine, offset in the source, and kind.
"""
