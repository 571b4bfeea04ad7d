"""ADS states and notification transmission modes.

Source: 000 §3.2.3.4 (Read State) and §3.2.3.6; numbers of modes and states from public client code.
"""

from enum import IntEnum


class AdsState(IntEnum):
    """State of an ADS device (ADSSTATE)."""

    INVALID = 0
    IDLE = 1
    RESET = 2
    INIT = 3
    START = 4
    RUN = 5
    STOP = 6
    SAVE_CONFIG = 7
    LOAD_CONFIG = 8
    POWER_FAILURE = 9
    POWER_GOOD = 10
    ERROR = 11
    SHUTDOWN = 12
    SUSPEND = 13
    RESUME = 14
    CONFIG = 15
    RECONFIG = 16
    STOPPING = 17
    INCOMPATIBLE = 18
    EXCEPTION = 19


class TransmissionMode(IntEnum):
    """Condition for the samples of a notification (ADSTRANSMODE)."""

    NONE = 0
    CLIENT_CYCLE = 1
    CLIENT_ON_CHANGE = 2
    SERVER_CYCLE = 3
    SERVER_ON_CHANGE = 4
    SERVER_CYCLE_IN_CONTEXT = 5
    SERVER_ON_CHANGE_IN_CONTEXT = 6
    CLIENT_ONCE = 10
