"""Whether a stream still has a watcher."""

from __future__ import annotations

FIRST_WAIT_S = 30.0
"""How long a stream waits for its first subscriber: discovery can be slow."""

GRACE_S = 5.0
"""How long a stream stays without subscribers, once it had one."""


class Attachment:
    """The subscribers of one stream over time.

    States: expected (nobody has come yet), attached, alone (all have left); over, once the second
    or the first has lasted too long. A watcher that was killed leaves when the middleware notices.
    """

    def __init__(self, now: float) -> None:
        """Expect a subscriber.

        :param now: seconds, of a clock that does not jump
        """
        self.count = 0
        self.is_permanent = False
        """Whether the stream stays without subscribers too."""
        self._until = now + FIRST_WAIT_S

    def look(self, count: int, now: float) -> bool:
        """Take note of the number of subscribers; tell whether there is a new one."""
        came = count > self.count
        if self.count and not count:
            self._until = now + GRACE_S
        self.count = count
        return came

    def expect(self, now: float) -> None:
        """Expect a further subscriber, as long as for the first one."""
        self._until = max(self._until, now + FIRST_WAIT_S)

    def is_over(self, now: float) -> bool:
        """Tell whether nobody is there, nor expected any more."""
        return not (self.count or self.is_permanent) and now >= self._until
