"""What a channel keeps beside the program: modal groups, R parameters, zero shifts, tools."""
