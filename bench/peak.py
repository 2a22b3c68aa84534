"""Run a module as `python -m` does; say at the end how much memory it took at most, in kB."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path


def main() -> None:
    """Run what is named after `-m`."""
    sys.argv = sys.argv[2:]
    try:
        runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
    finally:
        # Not ru_maxrss, which begins with that of the parent.
        status = Path('/proc/self/status').read_text().splitlines()
        print(
            next(line.split()[1] for line in status if line.startswith('VmHWM')), file=sys.stderr
        )


if __name__ == '__main__':
    main()
