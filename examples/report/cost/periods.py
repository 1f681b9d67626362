"""What a period of the ball on the shaken table is made of."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import vibroimpact as vi
from report.cost.scenes import CHATTERING, DROP, PERIOD, ball

PERIODS = 200


@dataclass(frozen=True)
class Composition:
    """Impacts, and segments by kind, in one period."""

    impacts: float
    kinds: dict[str, float]


def of_chatter() -> Composition:
    """The average over a run."""
    run = vi.simulate(ball(*CHATTERING), [DROP], [0.0], (0.0, PERIODS * PERIOD))
    kinds = Counter(str(kind) for kind in run.segments["kind"])
    return Composition(len(run.impacts) / PERIODS, {kind: count / PERIODS for kind, count in kinds.items()})
