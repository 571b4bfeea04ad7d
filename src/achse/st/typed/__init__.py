"""The typed form: Structured Text after the checker, ready for code generators.

The checker (`achse.st.check`) turns trees and scopes into this form; code generators (`achse.plc`
in Python, machine code through `achse.native`) read nothing else. In it

- every name is a *storage* (`places`): a base, a byte offset that is known, index steps that are
  not, and the type of what is there;
- every expression is a *value* (`expressions`) with a type. Operands have exactly the types that
  the operator works on: each widening, cut, rounding and change of unit is a `Converted`;
- every call is bound: to a routine by its key, or to an entry of the block's table when the
  instance decides at run time;
- constants are folded, `SIZEOF` and enumeration values are numbers, conditional pragmas are gone;
- properties are calls of their GET and SET, references are followed, `S=`, `R=` and chains are
  nodes of their own.

**Types are flat.** `type` of a storage or value is one of BoolType, IntegerType, RealType,
TimeType, StringType (and WSTRING), PointerType (InterfaceType included), StructType, ArrayType.
Aliases, sub-ranges and enumerations are their base, see `flat`. A time, date or pointer computes
like the unsigned integer of its size.

**Where memory is.** `UnitBase` is a variable of a program or list: the PLC that places the units
knows its address, and its bit (`AT %IX0.3`). `StaticBase` is a VAR_STAT variable, there once.
`InstanceBase` is the function block instance that the routine runs on (`THIS^`). `FrameBase` is
the frame of the running call: result, parameters, locals, VAR_TEMP and hidden temporaries. Its
layout and first values are `Routine.frame` (a StructType: `default` is the image to start from).
`PointerBase` is the target of an address: `p^`, a REFERENCE, a VAR_IN_OUT. `CalleeBase` is only
in the arguments of a call: the frame of a function or method, the instance of a block.
`TemporaryBase` is a value that is put into a hidden variable of the frame, to have an address.

**A function block instance** begins with a pointer-sized header. It holds the `number` of its
block; `TypedProject.block_numbered` leads back. A variable of an interface holds the address of
an instance, so both dispatch the same way: header → block → `table` → routine key.

**A call**: evaluate `instance`; then do `inputs` in order (each stores into `CalleeBase`, or into
the unit of a program); run the routine; then do `outputs` in order (each reads `CalleeBase`). The
frame of a callee begins as its image before the first input is stored, and its
`Routine.opening` runs before its body.

**A worked example.** `nTotal := nTotal + aSteps[i];` in PROGRAM MAIN with three INTs comes as

    Do(Stored(nTotal, Converted(Computed(ADD, (
        Converted(Read(nTotal), DINT, EXTEND),
        Converted(Read(Storage(UnitBase("MAIN", aSteps), 0, INT, steps=(IndexStep(i', 0, 9, 2),)),
            DINT, EXTEND)), DINT), INT, CUT)))

where i' is `Converted(Read(i), DINT, EXTEND)`. `text.text_of` writes such a form in one line:
`nTotal := CUT.INT(ADD.DINT(EXTEND.DINT(nTotal), EXTEND.DINT(aSteps[EXTEND.DINT(i)])))`.
"""
