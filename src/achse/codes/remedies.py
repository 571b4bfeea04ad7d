"""Remedies: what helps against the codes that a newcomer meets, for the command line and the pages.

Source: ours; the meanings in the tables of the manuals say what happened.
"""

from achse.codes.ads import ReturnCode
from achse.codes.nc.errors import NcError


def remedy_of(code: int) -> str:
    """Return what helps against a code, a sentence without a full stop; empty if none is known."""
    return _REMEDIES.get(code, "")


_LIMITS = "`achse axis show AXIS` lists the limits and `achse axis set` changes them"
_OTHER_TARGET = "choose a target inside the soft limits, or move the limits: " + _LIMITS
_BACK = "reset the axis (`achse axis reset`) and move it back inside the soft limits"
_MASTER = "move the master into the range of the table, or use a cyclic table"
_SLAVE = "command the master, or end the coupling first (`achse axis decouple`)"

_ADS: dict[ReturnCode, str] = {
    ReturnCode.TARGET_PORT_NOT_FOUND: "check the AMS port (851 PLC, 500 and 501 NC, 10000 system)"
    " and that the runtime is started",
    ReturnCode.TARGET_MACHINE_NOT_FOUND: "check the NetId, and add the route on both computers"
    " (`achse ads route add`); `achse ads scan` lists the NetIds of a network",
    ReturnCode.HOST_UNREACHABLE: "check address, cable and firewall (TCP port 48898) of the host"
    " that the route names",
    ReturnCode.ACCESS_DENIED: "check user, password, key or certificate of the route",
    ReturnCode.ROUTER_MAILBOX_FULL: "keep fewer requests under way, wait for answers, and send"
    " large data in parts",
    ReturnCode.ROUTER_NO_MORE_QUEUES: "close connections that are not needed, or raise"
    " `max_connections` of the station",
    ReturnCode.SERVICE_NOT_SUPPORTED: "check the AMS port: another device offers the service, or"
    " none does",
    ReturnCode.INVALID_GROUP: "check index group and AMS port; the reference pages list the"
    " services of each port",
    ReturnCode.INVALID_OFFSET: "check the index offset, and that the axis, table or address that"
    " it names exists",
    ReturnCode.INVALID_ACCESS: "the value is read-only or write-only, or the password is wrong;"
    " the reference pages say which",
    ReturnCode.INVALID_SIZE: "send and read as many bytes as the type has; read the size with the"
    " symbol",
    ReturnCode.INVALID_DATA: "keep the value inside the range that the reference page of the"
    " service names",
    ReturnCode.NOT_READY: "wait until the device is in RUN (`achse ads state`, `achse wait`)",
    ReturnCode.BUSY: "wait for the request that is under way, and repeat yours",
    ReturnCode.INVALID_PARAMETER: "check the values of the request by its reference page",
    ReturnCode.NOT_FOUND: "check the name and the folder, and that the object exists",
    ReturnCode.SYMBOL_NOT_FOUND: "`achse symbols` lists the names; check the namespace and that"
    " the program is loaded",
    ReturnCode.SYMBOL_VERSION_INVALID: "release the handle, fetch a new one by name and read the"
    " symbols again",
    ReturnCode.INVALID_STATE: "`achse ads state` shows the state; start the PLC or bring the"
    " target to RUN",
    ReturnCode.NOTIFICATION_HANDLE_INVALID: "subscribe again: a restart or a lost connection ended"
    " the subscription",
    ReturnCode.NO_MORE_HANDLES: "release handles and subscriptions that are not needed; read many"
    " values by one sum command",
    ReturnCode.DEVICE_ACCESS_DENIED: "add a route to the client on the target, or allow the"
    " access there",
    ReturnCode.CLIENT_TIMEOUT: "check that the target has a route back to the client, and that it"
    " is in RUN; then raise the time-out",
    ReturnCode.CLIENT_PORT_NOT_OPEN: "open the connection before the first request",
    ReturnCode.CLIENT_NO_AMS_ADDRESS: "name NetId and AMS port of the target",
    ReturnCode.SOCKET_TIMED_OUT: "check address, cable and firewall (TCP port 48898)",
    ReturnCode.SOCKET_CONNECTION_REFUSED: "start the router or station there, or check the TCP"
    " port",
    ReturnCode.SOCKET_HOST_UNREACHABLE: "check address and network of the host",
}

_NC: dict[NcError, str] = {
    NcError.REQUEST_PARAMETER: "check each value of the request by its reference page",
    NcError.CHANNEL_ID: "`achse channel show` lists the channels",
    NcError.GROUP_ID: "check the id of the group in the configuration of the NC",
    NcError.AXIS_ID: "`achse axis show` lists the axes with ids and names",
    NcError.TABLE_ID: "`achse table show` lists the tables",
    NcError.AXIS_INCOMPATIBLE: "check the type of the axis; another type offers the function",
    NcError.AXIS_NOT_READY: "reset the axis (`achse axis reset`), then enable it",
    NcError.GROUP_BUSY: "wait until the axis is idle or stop it, or command with a buffer mode",
    NcError.SET_VELOCITY_NOT_ALLOWED: "give a velocity above 0 and up to the maximum of the axis: "
    + _LIMITS,
    NcError.TARGET_BEYOND_SOFT_LIMITS: _OTHER_TARGET,
    NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS: _OTHER_TARGET,
    NcError.SOFT_LIMIT_MIN_AT_START: _OTHER_TARGET,
    NcError.SOFT_LIMIT_MAX_AT_START: _OTHER_TARGET,
    NcError.SOFT_LIMIT_MIN_PASSED: _BACK,
    NcError.SOFT_LIMIT_MAX_PASSED: _BACK,
    NcError.ENABLE_MISSING: "enable the axis with the feed enable of the direction"
    " (`achse axis enable`, MC_Power)",
    NcError.SLAVE_ENABLE_MISSING: "enable the slave too (`achse axis enable`, MC_Power)",
    NcError.CONTROLLER_ENABLE_MISSING: "`achse axis enable` switches axes on, MC_Power does it in"
    " a PLC; reset an axis that lost its enable in motion",
    NcError.DRIVE_NOT_READY_AT_START: "look at the drive and its bus (`achse bus state`), reset and"
    " enable the axis",
    NcError.DRIVE_NOT_READY: "look at the drive and its bus (`achse bus state`), reset and enable"
    " the axis",
    NcError.DRIVE_IO_INVALID: "check cable, supply and state of the slaves (`achse bus state`),"
    " then reset the axis",
    NcError.ACCELERATION_NOT_POSITIVE: "give an acceleration above 0",
    NcError.DECELERATION_NOT_POSITIVE: "give a deceleration above 0",
    NcError.JERK_NOT_POSITIVE: "give a jerk above 0",
    NcError.SET_VELOCITY_RANGE: "give a velocity above 0",
    NcError.START_TYPE: "check the start type by the reference page of the start",
    NcError.START_AXIS_DATA: "check position and dynamics of the command: finite, above 0 and"
    " inside the limits of the axis",
    NcError.DYNAMICS_NOT_ALLOWED: "give dynamics inside the limits of the axis: " + _LIMITS,
    NcError.VELOCITY_NOT_PERMITTED: "give a velocity up to the maximum of the axis: " + _LIMITS,
    NcError.ACCELERATION_NOT_PERMITTED: "give accelerations up to those of the axis: " + _LIMITS,
    NcError.JERK_NOT_PERMITTED: "give a jerk up to that of the axis: " + _LIMITS,
    NcError.SET_VELOCITY_TOO_HIGH: "slow the master or choose a smaller ratio, or raise the maximum"
    " velocity of the axis: " + _LIMITS,
    NcError.JOB_FOR_SLAVE: _SLAVE,
    NcError.FUNCTION_FOR_SLAVE: _SLAVE,
    NcError.COUPLING_DURING_JOB: "wait until master and slave are idle, then couple",
    NcError.SLAVE_TYPE: "check how the axis is coupled (`achse axis show AXIS`): the request is for"
    " another kind of coupling",
    NcError.GEAR_FACTOR_ZERO: "give a ratio other than 0",
    NcError.MASTER_NOT_INSERTED: "couple the axis first, and check the id of its master",
    NcError.DECOUPLING_NOT_POSSIBLE: "the axis follows no master, or moves: stop it first",
    NcError.SLAVE_COUPLING_PARAMETER: "check the values of the coupling: finite, ratio not 0",
    NcError.FUNCTION_NOT_ALLOWED: "end what holds the axis first: its group, or an absolute encoder"
    " that keeps its position",
    NcError.FUNCTION_NOT_AVAILABLE: "check type and coupling of the axis: another one offers the"
    " function",
    NcError.SLAVE_TABLE_IN_USE: "decouple the slaves of the table first (`achse axis decouple`)",
    NcError.AXIS_LOCKED_BY_STOP: "take back Execute of MC_Stop, or wait for standstill",
    NcError.COMMAND_BUFFER_FULL: "wait until a buffered command begins: an axis buffers one",
    NcError.HOMING_CAM_NOT_FOUND: "check the reference cam, its input and the search direction",
    NcError.FOLLOWING_ERROR_POSITION: "look for a blocked or weak drive, lower the dynamics, or"
    " widen the window of the lag monitoring; then reset the axis",
    NcError.AXIS_CONSEQUENTIAL_ERROR: "clear the error of the other axis, then reset this one",
    NcError.GROUP_CONSEQUENTIAL_ERROR: "clear the error of the other axis, then reset this one",
    NcError.TABLE_NOT_FOUND: "`achse table show` lists the tables; create or load the table first",
    NcError.TABLE_NOT_MONOTONIC: "let the master positions of the table rise from row to row",
    NcError.TABLE_SLAVE_RANGE: "the slave would jump: take its position relative, move it there"
    " before, or let the change wait for the end of the cam",
    NcError.TABLE_MASTER_BELOW: _MASTER,
    NcError.TABLE_MASTER_ABOVE: _MASTER,
    NcError.PLC_AXIS_NOT_READY: "enable the axis by MC_Power, and wait for its Status",
    NcError.PLC_PARAMETER: "check the inputs of the block, and that its AXIS_REF is linked",
    NcError.PLC_COMMAND_NOT_PERMITTED: "wait for the state that the block needs, or stop the axis",
    NcError.PLC_BUFFER_MODE: "choose a buffer mode that the block takes",
    NcError.PLC_NOT_CALLED_CYCLICALLY: "call the block in each cycle until it is done",
}

_REMEDIES = {
    **{code.number: text for code, text in _ADS.items()},
    **{error.number: text for error, text in _NC.items()},
}
