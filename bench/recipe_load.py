"""Generates scripts one after another in a process of low priority, as a node's own one does.

It begins when it is told to, and prints a line for each script, until it is killed.
"""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from bt_orchestrator.child_process import be_modest

NICE = 19
RECIPES, OPERATIONS = 10, 60


class Load:
    """A process that generates."""

    def __init__(self) -> None:
        self.scripts = 0
        """How many it has made, once it has ended."""


@contextmanager
def recipe_load() -> Iterator[Load]:
    """Generate meanwhile."""
    load = Load()
    command = [sys.executable, '-m', 'bench.recipe_load']
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdout.readline()
            process.stdin.write(b'\n')
            process.stdin.flush()
            yield load
        finally:
            process.kill()
            load.scripts = len(process.stdout.readlines())


def main() -> None:
    """Make one script of each recipe, again and again."""
    be_modest(NICE)
    from bench.recipe_lines import drawn_line
    from bt_orchestrator.cli.bootstrap import installed_types
    from bt_orchestrator.planning.generate import generate
    from bt_orchestrator.sim.pace_judge import PaceJudge
    from bt_orchestrator.store.memory import MemoryStore

    lines = [drawn_line(seed, OPERATIONS) for seed in range(RECIPES)]
    types = installed_types()
    print('ready', flush=True)
    sys.stdin.readline()
    for line in itertools.cycle(lines):
        generate(line.cell, line.recipe, judge=PaceJudge(line.cell, types, MemoryStore))
        print('made', flush=True)


if __name__ == '__main__':
    main()
