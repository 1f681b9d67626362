"""The crate with steps of undamped, unforced motions without stops: Runge-Kutta, and Taylor series of a pendulum."""

from __future__ import annotations

from report.cost.bare.change import NEVER, Change

STEPPING, RUNGE_KUTTA, SERIES = (
    "src/simulate/stepping.rs",
    "src/simulate/stepping/runge_kutta.rs",
    "src/simulate/stepping/series.rs",
)
DYNAMICS, LINEAR, STEPPER = "src/model/dynamics.rs", "src/model/linear_motion.rs", "src/flow/runge_kutta.rs"
TAYLOR, SERIES_OF = "src/flow/taylor.rs", "src/flow/series_of.rs"
RELEASE = "src/simulate/stepping/release.rs"

# No force, no base motion, no load; no angle of theirs is carried along.
INPUTS = (
    Change(STEPPER, "        angle: at.angle + frequency * s,", "        angle: 0.0,"),
    Change(DYNAMICS, "        let Some(amplitude) = &self.0 else { return };", "", "    }\n}\n"),
    Change(
        DYNAMICS,
        "            Forcing::Harmonic(force) => Self(Some(force",
        f"            Forcing::Harmonic(_) => {NEVER},\n",
        "            Forcing::BaseMotion(_) | Forcing::Unforced",
    ),
    Change(
        DYNAMICS,
        "            Forcing::BaseMotion(base) => Self {",
        f"            Forcing::BaseMotion(_) => {NEVER},\n",
        "            Forcing::Harmonic(_) | Forcing::Unforced",
    ),
    Change(DYNAMICS, "            base * c0 - self.gravity * s0", "            -(self.gravity * s0)"),
    Change(DYNAMICS, "self.alpha * (base * c1 - self.gravity * s1", "self.alpha * (-(self.gravity * s1)"),
    Change(
        LINEAR, "            .map(|_| system.solve_mass_complex(&forcing.force_on(system)));", f"            .map(|_| {NEVER});"
    ),
    Change(LINEAR, "        a.copy_from_slice(self.load.as_slice());", "        a.fill(0.0);"),
    Change(
        SERIES_OF,
        "            Excitation::Base(base) => self.expand_shaken(coefficients, base),",
        f"            _ => {NEVER},\n",
        "        }\n    }\n",
    ),
)

# No damper, no damping matrix.
DAMPING = (
    Change(DYNAMICS, "        if let Some(c) = &self.damping {", "", "        self.force.add(at, &mut f);"),
    Change(
        DYNAMICS,
        "            damping: (damping != [0.0; 4]).then_some(damping),",
        f"            damping: if damping == [0.0; 4] {{ None }} else {{ {NEVER} }},",
    ),
    Change(
        LINEAR,
        "DMatrix::zeros(0, 0)\n            } else {\n                damping",
        f"DMatrix::zeros(0, 0)\n            }} else {{\n                {NEVER}",
    ),
    Change(LINEAR, "        if damping.is_empty() {\n            for j in 0..n {", "        {\n            for j in 0..n {"),
    Change(
        LINEAR,
        "            return;\n        }\n        for j in 0..n {",
        "        }\n",
        "    }\n}\n\nimpl OverMass for Diagonals",
    ),
    Change(SERIES_OF, "self.coefficients.damping.0.is_empty()", "true"),
    Change(TAYLOR, "            if IS_DAMPED {", "", "            let force = excitation.force"),
    Change(TAYLOR, "let driven = lane.rest[i][m] + (force[i][m] - drag[i][m]);", "let driven = lane.rest[i][m];"),
)

# No stop: no gap is looked at, no contact or release searched for along a step.
STOPS = (
    Change(
        STEPPING,
        "        let contacts = Arc::new(contacts(scene));",
        "        assert!(scene.stops().is_empty());\n        let contacts = Arc::new(contacts(scene));",
    ),
    Change(RUNGE_KUTTA, "            self.look_ahead(h)?;\n            let undecided", "", "            halvings = 0;"),
    Change(RUNGE_KUTTA, "            if let Some((stop, x)) = released.filter(", "", "            self.keep(h, is_last"),
    Change(RUNGE_KUTTA, "            std::mem::swap(&mut self.gaps, &mut self.ahead);", ""),
    Change(
        SERIES,
        "        let found = self.contact_on_series(motion, starts, h);",
        "        let (span, arrival) = (h, is_last.then_some(Arrival::End));\n",
        "        Some(Leg { span, arrival })",
    ),
    Change(
        SERIES, "        if matches!(\n            leg.arrival,\n            Some(Arrival::Contact", "", "        Ok(leg.arrival)"
    ),
)

# Nothing is kept but the state.
KEPT = (
    Change(RUNGE_KUTTA, "            self.keep(h, is_last.then_some(last), record);", ""),
    Change(SERIES, "        self.keep_series(leg.span, is_last.then_some(last), record);", ""),
)

# Nobody is asked whether to go on.
WATCH = (
    Change(RUNGE_KUTTA, "            watch.work(self.n().pow(2))?;", ""),
    Change(SERIES, "            watch.work(mover.work())?;", ""),
)

APART = ()
