"""Limits of clients at the server: no client may fill its memory or hold its loop."""

from __future__ import annotations

# --- before somebody has logged in --------------------------------------------------------------

CONNECTIONS = 100
"""At a time, whoever they are of."""

PENDING = 24
"""Connections at a time without a login; one more closes the oldest of the address that has the
most of them: a client that opens many does not keep out others."""

PENDING_S = 10.0
"""Within so long somebody has to log in, or the connection is closed."""

PENDING_CHUNKS = 2
"""Parts of a message; a certificate fits into one."""

# --- of a connection ----------------------------------------------------------------------------

CHUNK_BYTES = 65_535
MESSAGE_BYTES = 2_000_000
SMALLEST_CHUNK_BYTES = 8_192
"""OPC 10000-6: smaller buffers are not allowed."""

WAITING_MESSAGES = 100
"""Requests of a connection that wait for their turn; one more closes it."""

UNREAD_BYTES = 8_000_000
"""Answers that a client does not read; more closes its connection."""

TOKEN_MS = (10_000, 3_600_000)
"""Lifetime of the keys of a connection."""

# --- of a session -------------------------------------------------------------------------------

SESSIONS = 50
SUBSCRIPTIONS_OF_SESSION = 20
SUBSCRIPTIONS = 200
ITEMS_OF_SESSION = 5_000
"""Nodes that it watches."""

DATA_QUEUES = 10, 100
"""Values of a node that wait for a client: usually, and at most."""

EVENT_QUEUES = 1_000, 1_000
KEPT_MESSAGES = 100
"""Notifications of a subscription that are kept until they are acknowledged."""

PUBLISHING_MS = (50.0, 60_000.0)
"""Publishing interval: below it the loop would do nothing else."""

KEEP_ALIVE_MS = 60_000.0
LIFETIME_MS = 600_000.0
"""A subscription without requests is gone after so long, at most."""

SESSION_MS = (5_000.0, 600_000.0)

# --- of a request -------------------------------------------------------------------------------

NODES = 1_000
"""Nodes in a request to read, write, or watch."""

BROWSED = 200
"""Nodes in a request to browse, or to find by their paths."""

SAME = 10
"""How often one value may be read in a request, or watched by a session: a list of orders may have
a megabyte, and is copied each time."""

STEP = 20
"""Nodes after which others get their turn."""

CALLED = 50
"""Methods in a request."""

SELECTED = 200
"""Fields of events that a client selects."""

CONDITIONS = 32
"""Elements of the condition by which a client selects events."""
