"""Why a job by recipe was made anew, and at what pace it is made since, for all surfaces."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MadeAnew:
    """A script was generated again, because other components are in service (semantics 7.5)."""

    without: tuple[str, ...] = ()
    """Components out of service that the script before needed, or did before it was made anew."""
    back: tuple[str, ...] = ()
    """Where none is: components that the script before did not need."""
    per_item_s: float = 0.0
    """Seconds from one item to the next; 0: not known."""
    before_s: float = 0.0
    """The same of the script before; where that was made without components, of the one before
    them. 0: not known."""

    @property
    def slower(self) -> float:
        """How much longer an item takes, as a part of the time before; 0: not known."""
        return self.per_item_s / self.before_s - 1 if self.before_s and self.per_item_s else 0.0

    @property
    def pace_words(self) -> str:
        """How long an item takes; empty: not known."""
        return compared_words(self.per_item_s, self.slower) if self.per_item_s else ''

    @property
    def words(self) -> str:
        """All in one sentence, as in `made anew without component_4b: 4.0 s per item (+33 %)`."""
        why = ' without ' if self.without else ' with ' if self.back else ''
        what = f'made anew{why}{" and ".join(self.without or self.back)}'
        return f'{what}: {self.pace_words}' if self.pace_words else what


def compared_words(per_item_s: float, slower: float) -> str:
    """Say how long one item takes, as in `18.1 s per item (+44 %)`.

    :param slower: than before, as a part of the time before
    """
    told = f' ({slower:+.0%})'.replace('%', ' %') if round(slower, 2) else ''
    return f'{per_item_s:.1f} s per item{told}'
