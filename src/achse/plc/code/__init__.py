"""Code of programs: the typed form of Structured Text as Python functions on PLC memory.

`emit_routine` writes one Python function per routine; its statements keep file and line of the
Structured Text, so tracebacks name that. Names in the functions are

- `D_h[12]`: memory of the data area as INTs, the twelfth. `I`, `Q`, `M`, `R`, `D` and `S` are the
  areas (`S`: frames), the letter after it the format of `struct`. A variable of a program has a
  number there that is known when the function is written;
- `this`: the address of the function block instance, `t_h[t2 + 3]` its INT at byte 6;
- `f`: the address of the frame, of routines with variables that need memory; the others are
  Python variables (`v_nCount`);
- everything else: functions of `operations`, `texts` and `pointers`.

A value is an int in the range of its type, a float (of REAL rounded to single precision), a bool,
or bytes: of a text without NUL, of a record or array all of them.
"""
