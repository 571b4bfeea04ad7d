"""Index groups that mean the same on every device, and those of a PLC's memory.

Sources: 000 §6.7, 002 §6.5, 003 §3.2 ("ADSIGRP_…"); what no manual prints is as clients use it. A
group that only one device offers is a row of that device, not a member here.
"""

from enum import IntEnum


class ReservedGroup(IntEnum):
    """Groups of 0xF000 and above: symbols, process image, sums, the device itself."""

    SYMBOL_HANDLE_BY_NAME = 0xF003
    """ReadWrite: name, gives a handle (SYM_HNDBYNAME)."""
    SYMBOL_VALUE_BY_NAME = 0xF004
    """ReadWrite: name, gives the value (SYM_VALBYNAME)."""
    SYMBOL_VALUE_BY_HANDLE = 0xF005
    """Read, Write; ReadWrite calls a method; the offset is the handle (SYM_VALBYHND)."""
    RELEASE_SYMBOL_HANDLE = 0xF006
    """Write: a handle (SYM_RELEASEHND)."""
    SYMBOL_INFO_BY_NAME = 0xF007
    """ReadWrite: name, gives group, offset, size (SYM_INFOBYNAME)."""
    SYMBOL_VERSION = 0xF008
    """Read: a number that changes with each download (SYM_VERSION)."""
    SYMBOL_ENTRY_BY_NAME = 0xF009
    """ReadWrite: name, gives a symbol entry (SYM_INFOBYNAMEEX)."""
    SYMBOL_TABLE = 0xF00B
    """Read: all symbol entries (SYM_UPLOAD)."""
    SYMBOL_TABLE_SIZE = 0xF00C
    """Read: count and bytes of the symbol table (SYM_UPLOADINFO)."""
    TYPE_TABLE = 0xF00E
    """Read: all data type entries (SYM_DT_UPLOAD)."""
    TABLE_SIZES = 0xF00F
    """Read: counts and bytes of both tables (SYM_UPLOADINFO2)."""
    SYMBOL_NOTIFICATION = 0xF010
    """AddNotification of a handle (SYMNOTE)."""
    TYPE_ENTRY_BY_NAME = 0xF011
    """ReadWrite: type name, gives a data type entry."""
    PROPERTY = 0xF019
    """In symbol entries: a property, which is read by a call, through a handle only."""
    INPUTS = 0xF020
    """Bytes of the inputs %I (IOIMAGE_RWIB)."""
    INPUT_BITS = 0xF021
    """Bits of the inputs; offset = 8 * byte + bit (IOIMAGE_RWIX)."""
    INPUTS_SIZE = 0xF025
    """Read: bytes of the inputs (IOIMAGE_RISIZE)."""
    OUTPUTS = 0xF030
    """Bytes of the outputs %Q (IOIMAGE_RWOB)."""
    OUTPUT_BITS = 0xF031
    """Bits of the outputs (IOIMAGE_RWOX)."""
    OUTPUTS_SIZE = 0xF035
    """Read: bytes of the outputs (IOIMAGE_ROSIZE)."""
    CLEAR_INPUTS = 0xF040
    """Write: all inputs become 0 (IOIMAGE_CLEARI)."""
    CLEAR_OUTPUTS = 0xF050
    """Write: all outputs become 0 (IOIMAGE_CLEARO)."""
    SUM_READ = 0xF080
    """ReadWrite: many reads, results before values (SUMUP_READ)."""
    SUM_WRITE = 0xF081
    """ReadWrite: many writes (SUMUP_WRITE)."""
    SUM_READ_WRITE = 0xF082
    """ReadWrite: many of its kind (SUMUP_READWRITE)."""
    SUM_READ_WITH_LENGTHS = 0xF083
    """ReadWrite: many reads, with result and length each (SUMUP_READEX)."""
    SUM_READ_SHORT = 0xF084
    """ReadWrite: as before, but values only as long as they are (SUMUP_READEX2)."""
    SUM_ADD_NOTIFICATION = 0xF085
    """ReadWrite: many notifications added (SUMUP_ADDDEVNOTE)."""
    SUM_DELETE_NOTIFICATION = 0xF086
    """ReadWrite: many notifications deleted (SUMUP_DELDEVNOTE)."""
    DEVICE = 0xF100
    """States and name of the device (DEVICE_DATA)."""


SUMS = range(ReservedGroup.SUM_READ, ReservedGroup.SUM_DELETE_NOTIFICATION + 1)
"""Groups of many requests in one."""

NAMED = frozenset(
    (
        ReservedGroup.SYMBOL_HANDLE_BY_NAME,
        ReservedGroup.SYMBOL_VALUE_BY_NAME,
        ReservedGroup.SYMBOL_INFO_BY_NAME,
        ReservedGroup.SYMBOL_ENTRY_BY_NAME,
        ReservedGroup.TYPE_ENTRY_BY_NAME,
    )
)
"""Groups whose requests carry the name of a symbol or type."""


OPEN_FILES = range(0xF600, 0xF700)
"""Of the system service: the handle of an open file as group (000 §5.1)."""

OPENS_FILE = (100, 101, 102, 120)
"""Groups of the system service whose answer is a file handle; the first three in the older form."""

CLOSE_FILE, CLOSE_FILE_LATER, FIND_FILE = 121, 111, 133
"""Groups that close a handle (the offset; in the older form the data), and a search with handle."""

FILES = frozenset((*range(100, 140), *OPEN_FILES))
"""Groups of the system service that are about files, those of the older form too (000 §5.1)."""


class PlcGroup(IntEnum):
    """Groups of a PLC's memory areas, besides the process image."""

    FLAGS = 0x4020
    """Bytes of the flags %M (READ_M, WRITE_M)."""
    FLAG_BITS = 0x4021
    """Bits of the flags; offset = 8 * byte + bit (READ_MX, WRITE_MX)."""
    FLAGS_SIZE = 0x4025
    """Read: bytes of the flags."""
    RETAIN = 0x4030
    """Bytes of the retain data (RWRB)."""
    RETAIN_BITS = 0x4031
    """Bits of it; in no manual, but BIT variables need an address as well."""
    RETAIN_SIZE = 0x4035
    """Read: bytes of the retain data."""
    DATA = 0x4040
    """Bytes of the data (RWDB)."""
    DATA_BITS = 0x4041
    """Bits of it; in no manual, as above."""
    DATA_SIZE = 0x4045
    """Read: bytes of the data."""
