"""Browsing: which types of references are below which one is worked out once."""

from __future__ import annotations

from asyncua import ua
from asyncua.server.address_space import AddressSpace, ViewService


class Views(ViewService):
    """asyncua walks the types of references for each reference of each node.

    500 nodes with many references would hold the loop for ten seconds.
    """

    def __init__(self, aspace: AddressSpace) -> None:
        super().__init__(aspace)
        self._below: dict[ua.NodeId, frozenset[ua.NodeId]] = {}

    def _get_sub_ref(self, ref: ua.NodeId) -> frozenset[ua.NodeId]:
        found = self._below.get(ref)
        if found is None:
            found = frozenset(super()._get_sub_ref(ref))
            if ref in self._aspace:  # clients may name any number of others
                self._below[ref] = found
        return found

    def forget(self) -> None:
        """Work it out anew: nodesets were loaded meanwhile."""
        self._below.clear()
