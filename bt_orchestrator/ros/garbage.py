"""The garbage collector looks less often, and never again at what is there to stay.

CPython's default is made for programs that are small: a look after 700 new objects, and from
time to time at everything. A node makes as many for one task, has some hundred thousand that
stay, and leaves nearly nothing that only the collector can free. A request with thousands of
orders makes a look at everything while its answer, and every ping, waits.
"""

from __future__ import annotations

import gc

NEW_OBJECTS = 20_000
"""A look at the new ones after so many; 4 MB at most would be garbage."""

OLDER_LOOKS = 20
"""Looks at one generation for each at the next older one."""


def collect_rarely() -> None:
    """Keep what is there out of all further looks; call it when everything has been made."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(NEW_OBJECTS, OLDER_LOOKS, OLDER_LOOKS)
