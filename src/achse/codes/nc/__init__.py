"""Facts of the motion controller, each once: service rows by area, their choices, error codes.

The devices bind behaviour to the rows; client, CLI, documentation and tests read them. Read `row`
first. A module is imported when its rows are needed, so nothing is imported here.
"""
