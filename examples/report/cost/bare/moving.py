"""The crate whose stops never come to rest in contact, and which keeps nothing; everything else is there."""

from __future__ import annotations

from report.cost.bare import flights, steps
from report.cost.bare.change import NEVER, Change

# Contact that lasts, and with it a motion along held stops.
REST = (
    *flights.REST,
    Change(
        steps.STEPPING,
        "        self.is_begun = false;\n        let held = self.held_motion();",
        f"        {NEVER}\n",
        "    }\n\n    fn stay(",
    ),
)
KEPT = (
    *flights.KEPT,
    Change(steps.RUNGE_KUTTA, "            if let Some(record) = &mut keeping {", "", "            self.arrive(h);"),
    Change(steps.SERIES, "        self.keep_series(series, leg.span, is_last.then_some(last), record);", ""),
    Change(
        steps.RUNGE_KUTTA,
        "                let s = self.land(dynamics, (stop, order), (x * h, passed * h), h)?;",
        "                let s = self.land(dynamics, (stop, order), (x * h, passed * h), h)?;\n",
        "                self.arrive(s);",
    ),
)
WATCH = (
    *flights.WATCH,
    *steps.WATCH,
    Change(
        steps.RUNGE_KUTTA,
        "            steps.begin()?;\n            let (h, next, is_last) =",
        "            let (h, next, is_last) =",
    ),
    Change(steps.SERIES, "                steps.begin()?;\n                let arrival =", "                let arrival ="),
)
APART = (*flights.APART, *steps.APART)
