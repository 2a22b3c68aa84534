"""The ports: what the orchestrator needs from outside, independent of the implementation.

Every implementation of a port passes the contract tests of that port (test/contract).
"""

from bt_orchestrator.ports.clock import Clock, Timer
from bt_orchestrator.ports.door import CellLink, EventPage, Listener, Moment, QueuePage, Watch
from bt_orchestrator.ports.generating import Generating, MadeScript
from bt_orchestrator.ports.journal import EventStore, Journal, Seen, Snapshot, StandbyJournal
from bt_orchestrator.ports.planning import (
    CheckedOrder,
    Consequence,
    ExpectedJob,
    Foresight,
    JobChange,
    Past,
    Planning,
    Proposal,
    ProposedJob,
    WhatIf,
    WrongField,
)
from bt_orchestrator.ports.records import Records
from bt_orchestrator.ports.servers import ActionGateway, ActionTypes, Goal, Servers, Told
from bt_orchestrator.ports.writing import (
    Bookkeeping,
    EventSink,
    StopSearch,
    Worker,
    Writer,
    Writing,
)

__all__ = [
    'Goal',
    'Told',
    'Servers',
    'ActionGateway',
    'ActionTypes',
    'Timer',
    'Clock',
    'Snapshot',
    'EventStore',
    'Journal',
    'Seen',
    'StandbyJournal',
    'Records',
    'Writing',
    'StopSearch',
    'Worker',
    'Writer',
    'EventSink',
    'Bookkeeping',
    'Foresight',
    'MadeScript',
    'Generating',
    'EventPage',
    'Moment',
    'QueuePage',
    'Listener',
    'Watch',
    'CellLink',
    'Past',
    'ExpectedJob',
    'JobChange',
    'Consequence',
    'WrongField',
    'CheckedOrder',
    'WhatIf',
    'Planning',
    'Proposal',
    'ProposedJob',
]
