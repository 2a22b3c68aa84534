"""Run a module as `python -m` does; say at the end how much memory it took, in kB."""

from __future__ import annotations

import resource
import runpy
import sys


def main() -> None:
    """Run what is named after `-m`."""
    sys.argv = sys.argv[2:]
    try:
        runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
    finally:
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)


if __name__ == '__main__':
    main()
