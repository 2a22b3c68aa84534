"""Circles in a graph of waits."""

from __future__ import annotations

from collections.abc import Iterable


def circles(edges: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Return circles, each as its nodes in order with the first repeated at the end.

    There is at least one if the graph has any; of circles that share nodes only one is returned,
    which is enough to say what is wrong there.
    """
    following: dict[str, list[str]] = {}
    for upstream, downstream in edges:
        following.setdefault(upstream, []).append(downstream)
    found: list[list[str]] = []
    closed: set[str] = set()
    for start in following:
        circle = _circle(start, following, closed)
        if circle is not None:
            found.append(circle)
    return found


def _circle(start: str, following: dict[str, list[str]], closed: set[str]) -> list[str] | None:
    """Walk depth first without recursion; `closed` nodes were left for good."""
    path: list[str] = []
    branches: list[list[str]] = [[start]]
    while branches:
        if not branches[-1]:
            branches.pop()
            if path:
                closed.add(path.pop())
            continue
        node = branches[-1].pop(0)
        if node in path:
            closed.update(path)
            return [*path[path.index(node) :], node]
        if node not in closed:
            path.append(node)
            branches.append(list(following.get(node, ())))
    return None
