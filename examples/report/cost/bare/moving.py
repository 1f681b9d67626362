"""The crate whose stops never come to rest in contact, and which keeps nothing; everything else is there."""

from __future__ import annotations

from report.cost.bare import flights, steps
from report.cost.bare.change import NEVER, Change

# Contact that lasts, and with it a motion along held stops.
REST = (
    *flights.REST,
    Change(
        steps.SCENE,
        "        self.is_begun = false;\n        let motion = self.motion_in(&self.regime);",
        f"        {NEVER}\n",
        "    }\n\n    pub(super) fn counts(",
    ),
)
KEPT = (
    *flights.KEPT,
    Change(
        steps.STEPS,
        "            if is_recorded {\n                self.record(dynamics, h, is_last",
        "",
        "            self.arrive(h);\n            self.advance_gaps",
    ),
    Change(steps.SERIES, "        system.record_series(series, step.span, is_last.then_some(last), recorder);", ""),
    Change(
        steps.LANDING,
        "            self.note_extent(stop, s, self.ahead[stop].speed);\n        }\n",
        "            self.note_extent(stop, s, self.ahead[stop].speed);\n        }\n",
        "        self.arrive(s);",
    ),
)
WATCH = (
    *flights.WATCH,
    *steps.WATCH,
    Change(
        steps.STEPS,
        "            steps.begin()?;\n            let (h, next, is_last) =",
        "            let (h, next, is_last) =",
    ),
    Change(steps.SERIES, "            steps.begin()?;\n            let arrival =", "            let arrival ="),
)
APART = (*flights.APART, *steps.APART)
