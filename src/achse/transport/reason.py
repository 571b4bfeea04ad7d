"""Reason of a failed socket call, in the words of the operating system."""

import os


def reason(failure: OSError) -> str:
    """`Connection refused`, `Address already in use`, …

    asyncio puts the address, and the call that failed, into the text; the caller knows the place.
    """
    if failure.errno is not None and failure.errno > 0:
        return os.strerror(failure.errno)
    return failure.strerror or str(failure)
