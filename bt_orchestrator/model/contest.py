"""Contests: a second server of a component, or goals that are not the line's (2.5)."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.words import Words


@dataclass(frozen=True)
class Contest:
    """Other servers or clients of a component; empty: only the line uses it."""

    servers: tuple[str, ...] = ()
    """Nodes of all servers of its action, if there are several: each would execute a goal."""
    goals: tuple[str, ...] = ()
    """UUIDs of goals there that belong to no task of the line."""

    def __bool__(self) -> bool:
        """Tell whether there is a contest."""
        return bool(self.servers or self.goals)

    def wait(self, component: str, action: str) -> str:
        """Say what a task waits for."""
        if self.servers:
            return f'waiting for {component} to have one server; there are {self.words(action)}'
        return f'waiting for {component}; {self.words(action)}'

    def facts(self, action: str) -> Words:
        """Return what `words` says as facts, of a contest that there is."""
        if self.servers:
            count, servers = str(len(self.servers)), ', '.join(self.servers)
            return Words('several_servers', {'action': action, 'count': count, 'servers': servers})
        kind = 'foreign_goals' if len(self.goals) > 1 else 'foreign_goal'
        return Words(kind, {'goals': ', '.join(self.goals)})

    def words(self, action: str) -> str:
        """Describe the contest; empty: there is none."""
        return self.facts(action).text() if self else ''


NO_CONTEST = Contest()
