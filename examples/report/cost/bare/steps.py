"""The crate with steps of undamped, unforced motions without stops: Runge-Kutta, and Taylor series of a pendulum."""

from report.cost.bare.change import NEVER, Change

SCENE, STEPS, LANDING, SERIES = (
    "src/hybrid/integrated/scene.rs",
    "src/hybrid/integrated/steps.rs",
    "src/hybrid/integrated/landing.rs",
    "src/hybrid/integrated/series.rs",
)
DYNAMICS, MOMENT, BY_METHOD = "src/model/dynamics.rs", "src/model/moment.rs", "src/simulate/by_method.rs"
TAYLOR, SERIES_OF = "src/flow/taylor.rs", "src/flow/series_of.rs"

# No force, no base motion, no load; no angle of theirs is carried along.
INPUTS = (
    Change(MOMENT, "            angle: self.angle + self.frequency * span,", "            angle: 0.0,"),
    Change(BY_METHOD, "            ByParts::Driven($by) => $body,", f"            ByParts::Driven(_) => {NEVER},"),
    Change(BY_METHOD, "            ByParts::DampedDriven($by) => $body,", f"            ByParts::DampedDriven(_) => {NEVER},"),
    Change(
        BY_METHOD,
        "            ByInput::Driven(m) => in_steps::<[f64; 4], DormandPrinceSteps, _>(&m, given, (), visit),",
        f"            ByInput::Driven(_) => {NEVER},",
    ),
    Change(
        SERIES_OF,
        "            PendulumForcing::Base(base) => expand_shaken(about, base),",
        f"            _ => {NEVER},\n",
        "        }\n    }\n",
    ),
)

# No damper, no damping matrix.
DAMPING = (
    Change(DYNAMICS, "        if let Some(c) = &self.damping {", "", "        let levers ="),
    Change(
        DYNAMICS,
        "            damping: (damping != [0.0; 4]).then_some(damping),",
        f"            damping: if damping == [0.0; 4] {{ None }} else {{ {NEVER} }},",
    ),
    Change(BY_METHOD, "            ByParts::Damped($by) => $body,", f"            ByParts::Damped(_) => {NEVER},"),
    Change(SERIES_OF, "self.coefficients.damping.0.is_empty()", "true"),
    Change(TAYLOR, "            if IS_DAMPED {", "", "            let force = excitation.force"),
    Change(TAYLOR, "let driven = lane.rest[i][m] + (force[i][m] - drag[i][m]);", "let driven = lane.rest[i][m];"),
)

# No stop, and nothing kept but the state: flights are gone through.
STOPS = (
    Change(
        SCENE,
        "        let contacts = Arc::new(contacts(scene));",
        "        assert!(scene.stops().is_empty());\n        let contacts = Arc::new(contacts(scene));",
    ),
    Change(
        STEPS,
        "        self.grazes.clear();\n        self.doubt = None;\n        self.forget_extents();\n",
        f"        {NEVER}\n",
        "    }\n}\n",
    ),
    Change(
        SERIES,
        "        loop {\n            steps.begin()?;\n            let arrival = search.step_on(",
        f"        {NEVER}\n",
        "    }\n\n    fn record_instant(",
    ),
)

# Nobody is asked whether to go on.
WATCH = (
    Change(STEPS, "            steps.begin()?;\n            match self.try_step(", "            match self.try_step("),
    Change(SERIES, "            steps.begin()?;\n            self.expand(", "            self.expand("),
)

APART = ()
