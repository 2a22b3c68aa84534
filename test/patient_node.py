"""The tree node, which waits an hour for the ends of cancelled goals: no grace time, no farewell.

    python test/patient_node.py run --cell CELL ...

What ends it before did not wait for a time to run out, however slow the machine is.
"""

from __future__ import annotations

import sys

from bt_orchestrator.cli.main import main
from bt_orchestrator.engine.runtime import flights
from bt_orchestrator.ros import node

if __name__ == '__main__':
    node.FAREWELL_S = flights.GRACE_S = 3600.0
    sys.exit(main(sys.argv[1:]))
