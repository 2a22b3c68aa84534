"""`python -m bt_orchestrator` is the program `bt-orchestrator`."""

from __future__ import annotations

import sys

from bt_orchestrator.cli.main import main

sys.exit(main())
