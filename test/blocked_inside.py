"""The program in a process in which it cannot import the inside of rclpy; rclpy itself can.

python test/blocked_inside.py run --cell CELL ...
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Mapping
from typing import Any

from bt_orchestrator.cli.main import main

INSIDE = 'rclpy.impl'


def block() -> None:
    """Refuse it to our modules from now on."""
    original = builtins.__import__

    def importing(
        name: str,
        globals: Mapping[str, Any] | None = None,  # noqa: A002 - as it is called
        *rest: Any,
        **more: Any,
    ) -> Any:
        importer = str((globals or {}).get('__name__', ''))
        if name.startswith(INSIDE) and importer.startswith('bt_orchestrator'):
            raise ImportError(f'{INSIDE} is blocked')
        return original(name, globals, *rest, **more)

    builtins.__import__ = importing


if __name__ == '__main__':
    block()
    sys.exit(main(sys.argv[1:]))
