"""The crate with exact flights of an undamped, unforced scene with one stop that is never at rest, and nothing else."""

from __future__ import annotations

from report.cost.bare.change import NEVER, Change

SCENE, BLOCK = "src/flow/scene_flow.rs", "src/flow/block.rs"
REGISTERS = "src/flow/registers.rs"
MODAL_BLOCK, PROPAGATION = "src/modal/block.rs", "src/modal/propagation.rs"
LOOP = "src/simulate/event_loop.rs"
RESOLVER, SETTLE, STRIKE = (f"src/hybrid/resolver{part}.rs" for part in ("", "/hold_or_release", "/strike"))
EXACT, KEEP, NEXT = "src/hybrid/closed_form/system.rs", "src/hybrid/closed_form/arcs.rs", "src/event/next.rs"

# One type of flow, without inputs.
INPUTS = (
    Change(
        SCENE, "            $crate::flow::SceneFlow::Loaded($flow) => $body,", f"            _ => {NEVER},\n", "        }\n    };"
    ),
    Change(
        SCENE,
        "        if let Some(split) = SplitFlow::new(",
        f"        {NEVER}\n",
        "    }\n    let drive = Undriven;",
    ),
    Change(SCENE, "    SceneFlow::Loaded(BlockFlow::new(", f"    {NEVER}\n", "}\n\n/// Runs a block of code"),
    Change(
        SCENE,
        "        Form::Dense(matrix) => SceneFlow::Dense",
        f"        Form::Dense(_) => {NEVER},\n",
        "    }\n}\n",
    ),
)

# One kind of block: an oscillator that neither decays nor grows.
DAMPING = (
    Change(PROPAGATION, "    Over {\n        w2: f64,", "", "}\n\nimpl Propagation"),
    Change(
        PROPAGATION, "            Self::Spiral { sigma, omega } => [omega, sigma],", "", "        }\n    }\n\n    /// `e^{A t}`."
    ),
    Change(PROPAGATION, "sin_cos(turn), exp(growth))", "sin_cos(turn), 1.0)"),
    Change(REGISTERS, "powers: exponentials(self.1),", "powers: [1.0; K],"),
    Change(PROPAGATION, "                let c = power * cos;\n", ""),
    Change(PROPAGATION, "[[c + eta * s, s], [-w2 * s, c - eta * s]]", "[[cos, s], [-w2 * s, cos]]"),
    Change(PROPAGATION, "            Self::Over {\n                w2,\n", "", "        }\n    }\n\n    /// Response"),
    Change(
        PROPAGATION,
        "        let [[first, s], [cross, second]] = *exponential;",
        f"        {NEVER}\n",
        "    }\n}\n\nfn is_far_from_one",
    ),
    Change(
        MODAL_BLOCK,
        "                OscillatorRoots::Under { damped_frequency } => Propagation::Under {",
        "                OscillatorRoots::Under { damped_frequency } if eta == 0.0 => Propagation::Under {",
    ),
    Change(
        MODAL_BLOCK,
        "                OscillatorRoots::Over { l1, l2, half_gap } => Propagation::Over {",
        f"                _ => {NEVER},\n",
        "            },\n            Self::Spiral",
    ),
    Change(
        MODAL_BLOCK,
        "            Self::Spiral { sigma, omega } => Propagation::Spiral { sigma, omega },",
        f"            _ => {NEVER},\n",
        "        }\n    }\n",
    ),
)

# Impacts of one stop at a time.
SEVERAL = (
    Change(
        EXACT,
        "        let stops = 0..scene.n_stops();",
        "        assert!(scene.n_stops() == 1);\n        let stops = 0..scene.n_stops();",
    ),
    Change(STRIKE, " self.is_coupled(system) {", " false {"),
    Change(
        NEXT,
        "        for _ in 1..self.gaps.len() {",
        "        (stop, time)\n",
        "    }\n\n    /// The time of a contact to rounding",
    ),
)

# Whether impacts accumulate or contact lasts is asked, for an answer that is taken for granted would be a wrong one; what then
# follows is taken out.
REST = (
    Change(
        RESOLVER,
        "            return self.accumulate(system, reached, t_end, recorder);",
        f"            {NEVER};",
    ),
    Change(
        RESOLVER,
        "            return self.come_to_rest(system, t_end, recorder);",
        f"            {NEVER};",
    ),
    Change(
        SETTLE,
        "        if resting.is_empty() && self.were_held.is_empty() {",
        "        if resting.is_empty() && self.were_held.is_empty() {\n"
        f"            return Ok(Ok(()));\n        }}\n        {NEVER}\n",
        "    }\n\n    /// A stop held whose force",
    ),
    Change(
        RESOLVER,
        "            Outcome::Release => match self.struck_beside(system) {",
        f"            _ => {NEVER},\n",
        "        };\n        self.settle_compliant(system, resolved?, recorder)",
    ),
    Change(
        EXACT, "        if let Some(motion) = &self.regime_motion {", "", "        self.grazed.clear();\n        let FirstEvent"
    ),
    Change(EXACT, "        self.regime_motion = Some(motion);", f"        {NEVER};"),
)

# Nothing is kept but the state.
KEPT = (
    Change(
        KEEP,
        "        let wanted = recorder.wanted();\n        if wanted.events {",
        "",
        "    }\n\n    /// Records what is left of impacts",
    ),
    Change(STRIKE, "        if recorder.wanted().events {", "", "    }\n}\n\n/// Whether the motion leaves"),
)

# Nobody is asked whether to go on.
WATCH = (
    Change(LOOP, "            observer.work(work)?;\n", ""),
    Change(NEXT, "            if let Some(work) = made {", "", "            let StepAdvance { count, are_clear } ="),
    Change(
        NEXT,
        "                observer.work(STEPS_PER_REACH_CHECK * self.state.len())?;",
        "",
        "                self.leave_out();",
    ),
)

RUN = "src/simulate/run.rs"
# What the compiler keeps apart in the whole crate it would put into its callers where less is left of them.
APART = tuple(
    Change(path, start, f"{indent}#[inline(never)]\n{start}")
    for path, indent, start in (
        (NEXT, "    ", "    pub fn next(\n"),
        (NEXT, "    ", "    fn polish("),
        (NEXT, "    ", "    pub fn arrive("),
        (NEXT, "", "fn newton_step("),
        (EXACT, "    ", "    fn advance_to_event(\n"),
        (KEEP, "    ", "    pub(super) fn record("),
        (BLOCK, "    ", "    fn prepare("),
        (RUN, "    ", "    pub fn run(\n"),
    )
)
