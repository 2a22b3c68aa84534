"""The checksum of each row of a journal: a changed bit is detected when it is read."""

from __future__ import annotations

import zlib


def check_of(key: int, text: bytes) -> int:
    """Return the check of a row: CRC-32 over its text, seeded with its key.

    It detects errors of disk and memory. It does not detect a deliberate change of a row and its
    check.
    """
    return zlib.crc32(text, key & 0xFFFFFFFF)


def check_of_event(seq: int, text: bytes, ends: int) -> int:
    """Return the check of the row of an event.

    :param ends: 1: it is the last one of its commit; 0: it is not
    """
    return check_of(2 * seq + ends, text)
