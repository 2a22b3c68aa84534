"""How many examples a property is tried on: few for every change, many in the night."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TypeVar

from hypothesis import HealthCheck, Phase, seed, settings

Test = TypeVar('Test', bound=Callable[..., None])

PROFILE = os.environ.get('HYPOTHESIS_PROFILE', 'gate')
"""`gate`: the same few examples in every run; `nightly`: many, and new ones (scripts/nightly);
`shard`: a round of these, by the seed of a commit (.ci/shard)."""

SHARE = {'nightly': 1, 'shard': 40}


def examples(gate: int, nightly: int, drawn: int | None = None) -> Callable[[Test], Test]:
    """Return settings for a property over whole lines, which may take its time.

    :param drawn: the seed in the gate; None: hypothesis makes one from the text of the test, which
        draws others as soon as a word of it is changed
    """
    how = settings(
        max_examples=max(1, nightly // SHARE[PROFILE]) if PROFILE in SHARE else gate,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink),
    )
    if drawn is None or PROFILE in SHARE:
        return how
    return lambda test: seed(drawn)(how(test))
