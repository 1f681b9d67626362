"""Faults put into the library on purpose, which the referees must find.

Copies the crate to target/faults, puts a switch for each fault into the copy (a text that is gone is an error, so that the
list stays true), builds the referees once, and runs them without and with each fault: every fault must bring scenes that
disagree and agreed before. From the root of the repository: python3 tests/referees/faults.py [scenes].
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple


class Fault(NamedTuple):
    """A fault: what is wrong, the file, the text there, the text that the fault puts in its place, and the test that finds it."""

    name: str
    meaning: str
    file: str
    sound: str
    faulty: str
    test: str = "runs::the_library_agrees"


SWITCH = """
pub(crate) fn has_fault(name: &str) -> bool {
    static FAULT: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    FAULT.get_or_init(|| std::env::var("VIBROIMPACT_FAULT").unwrap_or_default()) == name
}
"""

FAULTS = [
    Fault(
        "release",
        "a stop whose gap is drawn open stays held",
        "src/hybrid/resolver/hold_or_release.rs",
        "                Release::Leaves => self.root_orders[stop] = 2,\n",
        '                Release::Leaves if crate::has_fault("release") => shares.push((i, force.force)),\n'
        "                Release::Leaves => self.root_orders[stop] = 2,\n",
    ),
    Fault(
        "root",
        "the time of a contact is late by 1e-9 of the flight",
        "src/event/next.rs",
        "                for (z, d) in arrived.iter_mut().zip(&self.derivatives) {\n                    *z = d.after(step);",
        '                let late = if crate::has_fault("root") { 1e-9 * time } else { 0.0 };\n'
        "                let (step, time) = (step + late, time + late);\n"
        "                for (z, d) in arrived.iter_mut().zip(&self.derivatives) {\n"
        "                    *z = d.after(step);",
    ),
    Fault(
        "impact",
        "an impact changes the velocity of the highest mode with the wrong sign",
        "src/hybrid/closed_form/system.rs",
        "        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {\n"
        "            *z = [0, 1].map(|c| difference(z[c], jump[c] * impulse));\n"
        "        }\n",
        "        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {\n"
        "            *z = [0, 1].map(|c| difference(z[c], jump[c] * impulse));\n"
        "        }\n"
        '        if crate::has_fault("impact") && self.state.len() > 1 {\n'
        "            let last = self.state.len() - 1;\n"
        "            let jump = self.scene.jumps[stop][last];\n"
        "            let z = &mut self.state[last];\n"
        "            *z = [z[0] + 2.0 * jump[0] * impulse, z[1] + 2.0 * jump[1] * impulse];\n"
        "        }\n",
    ),
    Fault(
        "lost stop",
        "the third stop of a scene is not looked at",
        "src/event/next.rs",
        "            !is_beyond_reach\n",
        '            !(is_beyond_reach || stop == 2 && crate::has_fault("lost stop"))\n',
    ),
    Fault(
        "stale force",
        "stops that stay when one is let go keep the motion, and the forces, of those held before",
        "src/hybrid/resolver/hold_or_release.rs",
        "        self.enter(system)?;\n        Ok(Ok(()))\n    }\n\n    /// Whether a gap",
        '        if self.held.is_empty() || !crate::has_fault("stale force") {\n'
        "            self.enter(system)?;\n        }\n        Ok(Ok(()))\n    }\n\n    /// Whether a gap",
    ),
    Fault(
        "saltation",
        "an impact that a deviation delays moves it the wrong way",
        "src/impact/saltation.rs",
        "    deviations.ger(1.0, &slip, &delays, 1.0);\n",
        '    let sign = if crate::has_fault("saltation") { -1.0 } else { 1.0 };\n'
        "    deviations.ger(sign, &slip, &delays, 1.0);\n",
        "orbits::multipliers_are_those_of_the_return_map",
    ),
    Fault(
        "bend",
        "the way to a wall does not bend as the links turn",
        "src/model/contact.rs",
        "value.acceleration -= sign * l * (cos * a - sin * v * v);",
        'let bend = if crate::has_fault("bend") { 0.0 } else { sin * v * v };\n'
        "                    value.acceleration -= sign * l * (cos * a - bend);",
        "pendulums::pendulums_move_as_the_referee_says",
    ),
]


def copy_with_switches(root: Path, copy: Path) -> None:
    """Copy the crate, with a switch for each fault."""
    shutil.rmtree(copy, ignore_errors=True)
    copy.mkdir(parents=True)
    for name in ["src", "tests", "examples", "benches"]:
        shutil.copytree(root / name, copy / name)
    for name in ["Cargo.toml", "Cargo.lock", "README.md"]:
        shutil.copy(root / name, copy / name)
    with (copy / "src/lib.rs").open("a") as file:
        file.write(SWITCH)
    for fault in FAULTS:
        path = copy / fault.file
        text = path.read_text()
        count = text.count(fault.sound)
        if count != 1:
            sys.exit(f"fault {fault.name!r}: its text stands {count} times in {fault.file}, not once")
        path.write_text(text.replace(fault.sound, fault.faulty))


def build(copy: Path) -> str:
    """Build the referees of the copy; the path of the program."""
    target = os.environ.get("CARGO_TARGET_DIR", str(copy.parent))
    environment = os.environ | {"CARGO_TARGET_DIR": target, "RUSTFLAGS": "", "CARGO_PROFILE_TEST_DEBUG": "0"}
    command = ["cargo", "test", "--test", "referees", "--no-run"]
    run = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, check=False)
    found = re.search(r"Executable .*\((.*)\)", run.stderr)
    if found is None:
        sys.exit(run.stderr)
    return str(copy / found[1])


def disagreeing(program: str, name: str, fault: str, scenes: int) -> tuple[set[int], list[str]]:
    """Run a test of a referee: the scenes that disagree, and the lines that count them by classes."""
    environment = os.environ | {"VIBROIMPACT_FAULT": fault, "VIBROIMPACT_CASES": str(scenes)}
    run = subprocess.run([program, name, "--nocapture"], env=environment, capture_output=True, text=True, check=False)
    said = run.stdout + run.stderr
    if " scenes in " not in said and " looked at, " not in said:
        sys.exit(said)
    numbers = {int(n) for n in re.findall(r"^(?:scene|case) (\d+) (?!took)", said, re.MULTILINE)}
    return numbers, re.findall(r"^ +\d+ [a-z, -]+: \[", said, re.MULTILINE)


def main() -> None:
    """Run every fault; the exit code says whether all were found."""
    scenes = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    root = Path.cwd()
    copy = root / "target/faults"
    copy_with_switches(root, copy)
    program = build(copy)
    before = {}
    for test in dict.fromkeys(fault.test for fault in FAULTS):
        before[test] = disagreeing(program, test, "", scenes)[0]
        print(f"{test}: without a fault {len(before[test])} scenes disagree")
    missed = []
    for fault in FAULTS:
        found, classes = disagreeing(program, fault.test, fault.name, scenes)
        new = sorted(found - before[fault.test])
        counts = "; ".join(line.strip(" [").rstrip(":") for line in classes)
        print(f"{fault.name}: {fault.meaning}: {len(new)} more scenes disagree, the first {new[:5]} ({counts})")
        if not new:
            missed.append(fault.name)
    if missed:
        sys.exit(f"not found: {missed}")


if __name__ == "__main__":
    main()
