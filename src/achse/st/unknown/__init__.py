"""Missing names: what sources use and nothing declares, and stand-ins for it.

A library that comes without sources leaves types, constants and variables that only their names
and uses are known of: `fbSend.bBusy` is a member, `fbSend(bExecute := TRUE)` has an input,
`E_Mode.Auto` is a value, `ARRAY [1..Lib.cMost]` takes a whole number.
"""

from achse.st.unknown.libraries import keep_names_of
from achse.st.unknown.standins import stand_ins
from achse.st.unknown.walk import MissingNames

__all__ = ["MissingNames", "keep_names_of", "stand_ins"]
