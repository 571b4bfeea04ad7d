"""Lowering: the typed form of Structured Text as steps that any form of code writes alike.

It decides what both forms of code must agree on: where a storage is and which of its indexes are
checked (`places`, `placement`), the order of evaluation and the temporaries it needs (`values`),
how instance, arguments and outputs of a call follow each other, and what creates a record
(`calls`), what takes from the budget (`statements`), which variables have a frame and what they
begin with (`routines`). `nodes` is the lowered form. `achse.plc.code` writes it as Python,
`achse.plc.machine` as machine code.
"""
