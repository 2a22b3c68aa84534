"""Places on a page, in points from its upper left corner."""

from __future__ import annotations

from dataclasses import dataclass, replace

Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A place on the page."""

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Its right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Its lower edge."""
        return self.top + self.height

    @property
    def middle(self) -> float:
        """Half its width."""
        return self.left + self.width / 2

    @property
    def centre(self) -> float:
        """Half its height."""
        return self.top + self.height / 2

    def moved(self, right: float, down: float) -> Box:
        """Return the same box elsewhere."""
        return replace(self, left=self.left + right, top=self.top + down)
