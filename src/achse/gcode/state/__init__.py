"""State of a channel beside the program: modal groups, R parameters, zero shifts, tools."""
