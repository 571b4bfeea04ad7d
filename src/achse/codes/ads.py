"""Return codes: the number, name and meaning of every answer an AMS router or ADS device gives.

Source: 000 §7, 002 §8. A code travels as 32 bits, in the AMS header (router) or as the result that
begins every response (device); NC errors share the number space, see `nc`.
"""

from enum import Enum

_HRESULT_BASE = 0x9811_0000
"""An error code's HRESULT is this plus the number; the positive HRESULTs are their own number."""


class ReturnCode(Enum):
    """One row of the return code table.

    `number` is what travels; `vendor_name` is the identifier the manuals print; `text` is the
    meaning; `hresult` is the number as HRESULT, None for the socket errors, which have none.
    Two positive HRESULTs share their number with errors of the global group: both are members,
    and `of` gives the error.
    """

    number: int
    hresult: int | None
    vendor_name: str
    text: str

    def __new__(cls, number: int, vendor_name: str, text: str) -> "ReturnCode":
        member = object.__new__(cls)
        member.number = number
        member.vendor_name = vendor_name
        member.text = text
        if vendor_name.startswith("S_"):
            member.hresult = number
        elif vendor_name.startswith("WSA"):
            member.hresult = None
        else:
            member.hresult = _HRESULT_BASE + number
        member._value_ = number if member.hresult is None else member.hresult
        return member

    def __int__(self) -> int:
        return self.number

    @staticmethod
    def of(number: int) -> "ReturnCode | None":
        """Return the code that travels as `number`, or None if the manuals print none."""
        return _BY_NUMBER.get(number)

    # global
    NO_ERROR = (0x0, "ERR_NOERROR", "Success.")
    INTERNAL_ERROR = (0x1, "ERR_INTERNAL", "Error inside the system.")
    NO_REALTIME = (0x2, "ERR_NORTIME", "Real-time part is missing.")
    ALLOCATE_LOCKED_MEMORY = (0x3, "ERR_ALLOCLOCKEDMEM", "Locked memory could not be obtained.")
    MAILBOX_INSERT = (
        0x4,
        "ERR_INSERTMAILBOX",
        "Message box is full, the message was not sent; fewer messages per cycle help.",
    )
    WRONG_RECEIVE_HMSG = (0x5, "ERR_WRONGRECEIVEHMSG", "HMSG is not the right one.")
    TARGET_PORT_NOT_FOUND = (
        0x6,
        "ERR_TARGETPORTNOTFOUND",
        "No such target port; the server is not started, not reachable or not installed.",
    )
    TARGET_MACHINE_NOT_FOUND = (
        0x7,
        "ERR_TARGETMACHINENOTFOUND",
        "No route to the target computer.",
    )
    UNKNOWN_COMMAND = (0x8, "ERR_UNKNOWNCMDID", "Command id not known.")
    BAD_TASK_ID = (0x9, "ERR_BADTASKID", "Task id not valid.")
    NO_IO = (0xA, "ERR_NOIO", "IO is missing.")
    UNKNOWN_AMS_COMMAND = (0xB, "ERR_UNKNOWNAMSCMD", "AMS command not known.")
    WIN32_ERROR = (0xC, "ERR_WIN32ERROR", "Error reported by Win32.")
    PORT_NOT_CONNECTED = (0xD, "ERR_PORTNOTCONNECTED", "Port has no connection.")
    INVALID_AMS_LENGTH = (0xE, "ERR_INVALIDAMSLENGTH", "Length field of the AMS packet is wrong.")
    INVALID_AMS_NET_ID = (0xF, "ERR_INVALIDAMSNETID", "AMS net id is wrong.")
    LOW_INSTALLATION_LEVEL = (
        0x10,
        "ERR_LOWINSTLEVEL",
        "Installed level is not high enough (TwinCAT 2 licence).",
    )
    NO_DEBUG = (0x11, "ERR_NODEBUGINTAVAILABLE", "Debugging is not offered.")
    PORT_DISABLED = (0x12, "ERR_PORTDISABLED", "Port is switched off; system service not running.")
    PORT_ALREADY_CONNECTED = (0x13, "ERR_PORTALREADYCONNECTED", "Port is connected already.")
    SYNC_WIN32_ERROR = (0x14, "ERR_AMSSYNC_W32ERROR", "Win32 error during a synchronous AMS call.")
    SYNC_TIMEOUT = (0x15, "ERR_AMSSYNC_TIMEOUT", "A synchronous AMS call ran into its timeout.")
    SYNC_AMS_ERROR = (0x16, "ERR_AMSSYNC_AMSERROR", "AMS error during a synchronous call.")
    SYNC_NO_INDEX_MAP = (0x17, "ERR_AMSSYNC_NOINDEXINMAP", "No index map for the synchronous call.")
    INVALID_AMS_PORT = (0x18, "ERR_INVALIDAMSPORT", "AMS port is wrong.")
    NO_MEMORY = (0x19, "ERR_NOMEMORY", "Out of memory.")
    TCP_SEND = (0x1A, "ERR_TCPSEND", "Sending over TCP failed.")
    HOST_UNREACHABLE = (0x1B, "ERR_HOSTUNREACHABLE", "Host cannot be reached.")
    INVALID_AMS_FRAGMENT = (0x1C, "ERR_INVALIDAMSFRAGMENT", "AMS fragment is wrong.")
    TLS_SEND = (0x1D, "ERR_TLSSEND", "Sending over TLS failed; no Secure ADS connection.")
    ACCESS_DENIED = (0x1E, "ERR_ACCESSDENIED", "Secure ADS refused the access.")

    # router
    ROUTER_NO_LOCKED_MEMORY = (
        0x500,
        "ROUTERERR_NOLOCKEDMEMORY",
        "Router cannot obtain locked memory.",
    )
    ROUTER_RESIZE_MEMORY = (0x501, "ROUTERERR_RESIZEMEMORY", "Router memory cannot be resized.")
    ROUTER_MAILBOX_FULL = (
        0x502,
        "ROUTERERR_MAILBOXFULL",
        "Message box holds the largest number of messages.",
    )
    ROUTER_DEBUG_BOX_FULL = (
        0x503,
        "ROUTERERR_DEBUGBOXFULL",
        "Debug message box holds the largest number of messages.",
    )
    ROUTER_UNKNOWN_PORT_TYPE = (0x504, "ROUTERERR_UNKNOWNPORTTYPE", "Kind of port not known.")
    ROUTER_NOT_INITIALIZED = (0x505, "ROUTERERR_NOTINITIALIZED", "Router not initialised.")
    ROUTER_PORT_IN_USE = (0x506, "ROUTERERR_PORTALREADYINUSE", "Port number is taken.")
    ROUTER_NOT_REGISTERED = (0x507, "ROUTERERR_NOTREGISTERED", "Port is not registered.")
    ROUTER_NO_MORE_QUEUES = (0x508, "ROUTERERR_NOMOREQUEUES", "No more ports can be opened.")
    ROUTER_INVALID_PORT = (0x509, "ROUTERERR_INVALIDPORT", "Port not valid.")
    ROUTER_NOT_ACTIVATED = (0x50A, "ROUTERERR_NOTACTIVATED", "Router is not running.")
    ROUTER_FRAGMENT_BOX_FULL = (
        0x50B,
        "ROUTERERR_FRAGMENTBOXFULL",
        "Box for fragmented messages is full.",
    )
    ROUTER_FRAGMENT_TIMEOUT = (0x50C, "ROUTERERR_FRAGMENTTIMEOUT", "A fragment came too late.")
    ROUTER_TO_BE_REMOVED = (0x50D, "ROUTERERR_TOBEREMOVED", "Port is about to be removed.")

    # ADS device
    DEVICE_ERROR = (0x700, "ADSERR_DEVICE_ERROR", "Unspecified device error.")
    SERVICE_NOT_SUPPORTED = (
        0x701,
        "ADSERR_DEVICE_SRVNOTSUPP",
        "The server does not offer this service.",
    )
    INVALID_GROUP = (0x702, "ADSERR_DEVICE_INVALIDGRP", "Index group not valid.")
    INVALID_OFFSET = (0x703, "ADSERR_DEVICE_INVALIDOFFSET", "Index offset not valid.")
    INVALID_ACCESS = (
        0x704,
        "ADSERR_DEVICE_INVALIDACCESS",
        "Read or write not allowed here (also a wrong password when a route is added).",
    )
    INVALID_SIZE = (0x705, "ADSERR_DEVICE_INVALIDSIZE", "Data size does not fit the parameter.")
    INVALID_DATA = (0x706, "ADSERR_DEVICE_INVALIDDATA", "Data values not valid.")
    NOT_READY = (0x707, "ADSERR_DEVICE_NOTREADY", "Device not ready.")
    BUSY = (0x708, "ADSERR_DEVICE_BUSY", "Device busy.")
    INVALID_CONTEXT = (
        0x709,
        "ADSERR_DEVICE_INVALIDCONTEXT",
        "Wrong operating-system context, for example ADS blocks used from different tasks;"
        " synchronise the tasks.",
    )
    DEVICE_NO_MEMORY = (0x70A, "ADSERR_DEVICE_NOMEMORY", "Device out of memory.")
    INVALID_PARAMETER = (0x70B, "ADSERR_DEVICE_INVALIDPARM", "Parameter values not valid.")
    NOT_FOUND = (0x70C, "ADSERR_DEVICE_NOTFOUND", "Object or file not found.")
    SYNTAX = (0x70D, "ADSERR_DEVICE_SYNTAX", "Syntax error in a file or command.")
    INCOMPATIBLE = (0x70E, "ADSERR_DEVICE_INCOMPATIBLE", "Objects do not fit together.")
    EXISTS = (0x70F, "ADSERR_DEVICE_EXISTS", "Object exists already.")
    SYMBOL_NOT_FOUND = (0x710, "ADSERR_DEVICE_SYMBOLNOTFOUND", "Symbol not found.")
    SYMBOL_VERSION_INVALID = (
        0x711,
        "ADSERR_DEVICE_SYMBOLVERSIONINVALID",
        "Symbol version outdated, for example after an online change; fetch a new handle.",
    )
    INVALID_STATE = (
        0x712,
        "ADSERR_DEVICE_INVALIDSTATE",
        "Server is in a state that does not allow this.",
    )
    TRANSMISSION_MODE_NOT_SUPPORTED = (
        0x713,
        "ADSERR_DEVICE_TRANSMODENOTSUPP",
        "Transmission mode not offered.",
    )
    NOTIFICATION_HANDLE_INVALID = (
        0x714,
        "ADSERR_DEVICE_NOTIFYHNDINVALID",
        "Notification handle not valid.",
    )
    CLIENT_UNKNOWN = (0x715, "ADSERR_DEVICE_CLIENTUNKNOWN", "Notification client not registered.")
    NO_MORE_HANDLES = (0x716, "ADSERR_DEVICE_NOMOREHDLS", "No handles left.")
    INVALID_WATCH_SIZE = (0x717, "ADSERR_DEVICE_INVALIDWATCHSIZE", "Notification data too large.")
    NOT_INITIALIZED = (0x718, "ADSERR_DEVICE_NOTINIT", "Device not initialised.")
    DEVICE_TIMEOUT = (0x719, "ADSERR_DEVICE_TIMEOUT", "Device timed out.")
    NO_INTERFACE = (0x71A, "ADSERR_DEVICE_NOINTERFACE", "Interface query failed.")
    INVALID_INTERFACE = (0x71B, "ADSERR_DEVICE_INVALIDINTERFACE", "Wrong interface requested.")
    INVALID_CLASS_ID = (0x71C, "ADSERR_DEVICE_INVALIDCLSID", "Class id not valid.")
    INVALID_OBJECT_ID = (0x71D, "ADSERR_DEVICE_INVALIDOBJID", "Object id not valid.")
    PENDING = (0x71E, "ADSERR_DEVICE_PENDING", "Request still pending.")
    ABORTED = (0x71F, "ADSERR_DEVICE_ABORTED", "Request aborted.")
    WARNING = (0x720, "ADSERR_DEVICE_WARNING", "Warning signal.")
    INVALID_ARRAY_INDEX = (0x721, "ADSERR_DEVICE_INVALIDARRAYIDX", "Array index not valid.")
    SYMBOL_NOT_ACTIVE = (0x722, "ADSERR_DEVICE_SYMBOLNOTACTIVE", "Symbol is not active.")
    DEVICE_ACCESS_DENIED = (
        0x723,
        "ADSERR_DEVICE_ACCESSDENIED",
        "Access refused (also a one-way route used the wrong way).",
    )
    LICENSE_NOT_FOUND = (0x724, "ADSERR_DEVICE_LICENSENOTFOUND", "Licence missing.")
    LICENSE_EXPIRED = (0x725, "ADSERR_DEVICE_LICENSEEXPIRED", "Licence expired.")
    LICENSE_EXCEEDED = (0x726, "ADSERR_DEVICE_LICENSEEXCEEDED", "Licence exceeded.")
    LICENSE_INVALID = (0x727, "ADSERR_DEVICE_LICENSEINVALID", "Licence not valid.")
    LICENSE_SYSTEM_ID = (
        0x728,
        "ADSERR_DEVICE_LICENSESYSTEMID",
        "Licence problem: system id not valid.",
    )
    LICENSE_NO_TIME_LIMIT = (
        0x729,
        "ADSERR_DEVICE_LICENSENOTIMELIMIT",
        "Licence has no time limit.",
    )
    LICENSE_FUTURE_ISSUE = (
        0x72A,
        "ADSERR_DEVICE_LICENSEFUTUREISSUE",
        "Licence problem: issue time is in the future.",
    )
    LICENSE_TIME_TOO_LONG = (0x72B, "ADSERR_DEVICE_LICENSETIMETOLONG", "Licence period too long.")
    EXCEPTION = (0x72C, "ADSERR_DEVICE_EXCEPTION", "Exception while the system started.")
    LICENSE_DUPLICATED = (
        0x72D,
        "ADSERR_DEVICE_LICENSEDUPLICATED",
        "Licence file was read a second time.",
    )
    SIGNATURE_INVALID = (0x72E, "ADSERR_DEVICE_SIGNATUREINVALID", "Signature not valid.")
    CERTIFICATE_INVALID = (0x72F, "ADSERR_DEVICE_CERTIFICATEINVALID", "Certificate not valid.")
    LICENSE_OEM_NOT_FOUND = (
        0x730,
        "ADSERR_DEVICE_LICENSEOEMNOTFOUND",
        "Public key of the OEM unknown.",
    )
    LICENSE_RESTRICTED = (
        0x731,
        "ADSERR_DEVICE_LICENSERESTRICTED",
        "Licence does not apply to this system id.",
    )
    LICENSE_DEMO_DENIED = (0x732, "ADSERR_DEVICE_LICENSEDEMODENIED", "Demo licence not allowed.")
    INVALID_FUNCTION_ID = (0x733, "ADSERR_DEVICE_INVALIDFNCID", "Function id not valid.")
    OUT_OF_RANGE = (0x734, "ADSERR_DEVICE_OUTOFRANGE", "Value out of range.")
    INVALID_ALIGNMENT = (0x735, "ADSERR_DEVICE_INVALIDALIGNMENT", "Alignment not valid.")
    LICENSE_PLATFORM = (0x736, "ADSERR_DEVICE_LICENSEPLATFORM", "Platform level not valid.")
    FORWARD_PASSIVE_LEVEL = (
        0x737,
        "ADSERR_DEVICE_FORWARD_PL",
        "Context: pass on to passive level.",
    )
    FORWARD_DISPATCH_LEVEL = (
        0x738,
        "ADSERR_DEVICE_FORWARD_DL",
        "Context: pass on to dispatch level.",
    )
    FORWARD_REALTIME = (0x739, "ADSERR_DEVICE_FORWARD_RT", "Context: pass on to real time.")

    # ADS client
    CLIENT_ERROR = (0x740, "ADSERR_CLIENT_ERROR", "Unspecified client error.")
    CLIENT_INVALID_PARAMETER = (
        0x741,
        "ADSERR_CLIENT_INVALIDPARM",
        "A parameter of the service is not valid.",
    )
    CLIENT_LIST_EMPTY = (0x742, "ADSERR_CLIENT_LISTEMPTY", "Polling list has no entries.")
    CLIENT_VARIABLE_USED = (0x743, "ADSERR_CLIENT_VARUSED", "Variable connection is in use.")
    CLIENT_DUPLICATE_INVOKE_ID = (0x744, "ADSERR_CLIENT_DUPLINVOKEID", "Invoke id is in use.")
    CLIENT_TIMEOUT = (
        0x745,
        "ADSERR_CLIENT_SYNCTIMEOUT",
        "No answer within the ADS timeout; the route back may be set wrongly.",
    )
    CLIENT_WIN32_ERROR = (0x746, "ADSERR_CLIENT_W32ERROR", "Error in the Win32 subsystem.")
    CLIENT_TIMEOUT_INVALID = (
        0x747,
        "ADSERR_CLIENT_TIMEOUTINVALID",
        "Timeout value of the client not valid.",
    )
    CLIENT_PORT_NOT_OPEN = (0x748, "ADSERR_CLIENT_PORTNOTOPEN", "Port is not open.")
    CLIENT_NO_AMS_ADDRESS = (0x749, "ADSERR_CLIENT_NOAMSADDR", "AMS address missing.")
    CLIENT_SYNC_INTERNAL = (
        0x750,
        "ADSERR_CLIENT_SYNCINTERNAL",
        "Error inside the synchronous ADS layer.",
    )
    CLIENT_ADD_HASH = (0x751, "ADSERR_CLIENT_ADDHASH", "Hash table overflow.")
    CLIENT_REMOVE_HASH = (0x752, "ADSERR_CLIENT_REMOVEHASH", "Key is not in the table.")
    CLIENT_NO_MORE_SYMBOLS = (0x753, "ADSERR_CLIENT_NOMORESYM", "No symbols cached.")
    CLIENT_SYNC_RESPONSE_INVALID = (
        0x754,
        "ADSERR_CLIENT_SYNCRESINVALID",
        "Received answer not valid.",
    )
    CLIENT_SYNC_PORT_LOCKED = (0x755, "ADSERR_CLIENT_SYNCPORTLOCKED", "Synchronous port is locked.")
    CLIENT_REQUEST_CANCELLED = (0x756, "ADSERR_CLIENT_REQUESTCANCELLED", "Request was cancelled.")

    # real time
    REALTIME_INTERNAL = (0x1000, "RTERR_INTERNAL", "Error inside the real-time system.")
    REALTIME_BAD_TIMER_PERIODS = (0x1001, "RTERR_BADTIMERPERIODS", "Timer value not valid.")
    REALTIME_INVALID_TASK = (0x1002, "RTERR_INVALIDTASKPTR", "Task pointer is null.")
    REALTIME_INVALID_STACK = (0x1003, "RTERR_INVALIDSTACKPTR", "Stack pointer is null.")
    REALTIME_PRIORITY_EXISTS = (0x1004, "RTERR_PRIOEXISTS", "Task priority is taken.")
    REALTIME_NO_MORE_TCB = (0x1005, "RTERR_NOMORETCB", "No task control block left (64 at most).")
    REALTIME_NO_MORE_SEMAPHORES = (0x1006, "RTERR_NOMORESEMAS", "No semaphore left (64 at most).")
    REALTIME_NO_MORE_QUEUES = (0x1007, "RTERR_NOMOREQUEUES", "No queue slot left (64 at most).")
    REALTIME_IRQ_ALREADY_DEFINED = (
        0x100D,
        "RTERR_EXTIRQALREADYDEF",
        "An external sync interrupt is in use already.",
    )
    REALTIME_IRQ_NOT_DEFINED = (0x100E, "RTERR_EXTIRQNOTDEF", "No external sync interrupt in use.")
    REALTIME_IRQ_INSTALL_FAILED = (
        0x100F,
        "RTERR_EXTIRQINSTALLFAILED",
        "External sync interrupt could not be installed.",
    )
    REALTIME_IRQL_NOT_LESS_OR_EQUAL = (
        0x1010,
        "RTERR_IRQLNOTLESSOREQUAL",
        "Service function called in the wrong context.",
    )
    REALTIME_VMX_NOT_SUPPORTED = (0x1017, "RTERR_VMXNOTSUPPORTED", "Processor has no VT-x.")
    REALTIME_VMX_DISABLED = (0x1018, "RTERR_VMXDISABLED", "VT-x is switched off in the BIOS.")
    REALTIME_VMX_CONTROLS_MISSING = (
        0x1019,
        "RTERR_VMXCONTROLSMISSING",
        "A VT-x function is missing.",
    )
    REALTIME_VMX_ENABLE_FAILS = (0x101A, "RTERR_VMXENABLEFAILS", "VT-x could not be switched on.")

    # positive HRESULT
    S_OK = (0x0, "S_OK", "Success.")
    S_FALSE = (0x1, "S_FALSE", "Success with a negative or incomplete result.")
    S_PENDING = (0x203, "S_PENDING", "Success, result not there yet.")
    S_WATCHDOG_TIMEOUT = (
        0x256,
        "S_WATCHDOG_TIMEOUT",
        "Success, although a time limit was exceeded.",
    )

    # winsock
    SOCKET_TIMED_OUT = (
        0x274C,
        "WSAETIMEDOUT",
        "Connecting timed out, or the peer of a connection stopped answering.",
    )
    SOCKET_CONNECTION_REFUSED = (
        0x274D,
        "WSAECONNREFUSED",
        "Target computer refused the connection, usually because no server runs there.",
    )
    SOCKET_HOST_UNREACHABLE = (0x2751, "WSAEHOSTUNREACH", "No route to the host.")


_BY_NUMBER = {code.number: code for code in reversed(ReturnCode)}
"""The last entry of a number wins, so that errors, which come first, beat positive HRESULTs."""
