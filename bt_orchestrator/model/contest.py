"""Who else has a part in a component: a second server, goals that are not the line's (2.5)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Contest:
    """What keeps the line from counting on a component; empty: it is the line's alone."""

    servers: tuple[str, ...] = ()
    """Where all servers of its action are, if there are several: each would execute a goal."""
    goals: tuple[str, ...] = ()
    """UUIDs of goals that run there and that no task of the line knows."""

    def __bool__(self) -> bool:
        """Tell whether there is anybody else."""
        return bool(self.servers or self.goals)

    def wait(self, component: str, action: str) -> str:
        """Say for what a task waits."""
        if self.servers:
            return f'waiting for {component} to have one server; there are {self.words(action)}'
        return f'waiting for {component}; {self.words(action)}'

    def words(self, action: str) -> str:
        """Say who there is; nothing if there is nobody else."""
        if self.servers:
            count = len(self.servers)
            return f'{count} servers of {action}: {", ".join(self.servers)}; stop all but one'
        if self.goals:
            several = 's' if len(self.goals) > 1 else ''
            return f'it runs goal{several} {", ".join(self.goals)}, which no task here waits for'
        return ''
