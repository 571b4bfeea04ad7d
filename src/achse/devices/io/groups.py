"""Index groups of the I/O server, of bus masters and of their slaves."""

from enum import IntEnum


class IoGroup(IntEnum):
    """Groups at port 300; the group of one device is `DEVICES` + its id."""

    DEVICES = 0x5000


class MasterGroup(IntEnum):
    """Groups of a bus master, port 65535 of its NetId."""

    MASTER_STATE = 0x0003
    SLAVE_COUNT = 0x0006
    SLAVE_ADDRESSES = 0x0007
    SLAVE_STATES = 0x0009
    FRAME_STATISTICS = 0x000C
    IDENTITY = 0x0011
    CRC_ERRORS = 0x0012
    ABNORMAL_CHANGES = 0x0013
    LOSSES = 0x0014
    TOPOLOGY = 0x0022
    FIRST_LINE = 0x002C
    CLOCK_DEVIATION = 0x002F
    DEV_STATE = 0x0045
    FRAME_COUNT = 0x0048
    ROUND_TRIPS = 0x0101
    WAY = 0x0102
    CLOCKS = 0x0103
    TROUBLE = 0x0104
    DATAGRAM = 0x0500


class SlaveGroup(IntEnum):
    """Groups of a slave, at the port of its station address; the master has SDO too."""

    SDO = 0xF302
    SDO_ERROR = 0xF303
    SDO_SUM_READ = 0xF304
    SDO_SUM_WRITE = 0xF305
    TX_PDO = 0xF3F8
    RX_PDO = 0xF3F9
    NETWORK_INFORMATION = 0xF3FB
    OBJECT_LIST = 0xF3FC
    OBJECT_DESCRIPTION = 0xF3FD
    ENTRY_DESCRIPTION = 0xF3FE
    FILE_OPEN_READ = 0xF401
    FILE_OPEN_WRITE = 0xF402
    FILE_CLOSE = 0xF403
    FILE_READ = 0xF404
    FILE_WRITE = 0xF405
    FILE_PROGRESS = 0xF406
    FILE_ERROR = 0xF407
    SERVO_PARAMETER = 0xF420
    SERVO_ERROR = 0xF421
    VENDOR_SPECIFIC = 0xF430
