"""Two frames that pound under a record: how hard, by which law of the bumper between them.

Two buildings of one storey, of 2.4 Hz and 1.1 Hz, stand 15 mm apart with a bumper between their roofs: a spring and a dashpot in
parallel, a stop on the difference of two coordinates. The ground follows a record made by the script (noise through the filter of
Kanai and Tajimi under an envelope). Papers on pounding mean different things by one dashpot: by Kelvin and Voigt it pulls before
the roofs part (`release="gap"`); others cut that off, `max(0, k p + c p')` ("clipped"). For one restitution they need different
damping ratios, and rigid roofs need none: their force has no size.

You will see the roofs, the force of the bumper in time, and over how far it is pressed for its hardest contact. The script
compares contacts with those by the Radau method, the impulses with the change of momentum, and the ledger; and the bumper with
one a hundred and ten thousand times as stiff, which comes near to rigid roofs by the root of its stiffness.

Run: python examples/pounding_frames.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

DURATION, RATE = 16.0, 100  # of the record [s], [samples/s]
PEAK = 3.0  # [m/s^2]
SOIL, SOIL_DAMPING = 2.0 * np.pi * 2.0, 0.6
MASS, HERTZ, RATIO = 1e5, (2.4, 1.1), 0.04  # of each building [kg], [Hz], [-]
ROOM = 0.015  # between the roofs [m]
BUMPER, RESTITUTION = 1e9, 0.6  # [N/m], [-]
PULLS = -np.log(RESTITUTION) / np.hypot(np.pi, np.log(RESTITUTION))  # the damping ratio of a dashpot that pulls


def record() -> tuple[np.ndarray, np.ndarray]:
    """Return times and accelerations like those of a strong earthquake."""
    t = np.arange(int(DURATION * RATE) + 1) / RATE
    noise = np.random.default_rng(7).normal(size=t.size)
    w = 2.0 * np.pi * np.fft.rfftfreq(t.size, 1.0 / RATE)
    filtered = (SOIL**2 + 2j * SOIL_DAMPING * SOIL * w) / (SOIL**2 - w**2 + 2j * SOIL_DAMPING * SOIL * w)
    shaken = np.fft.irfft(np.fft.rfft(noise) * filtered * (w > 2.0 * np.pi * 0.2), t.size)
    shaken *= np.minimum(t / 3.0, 1.0) ** 2 * np.exp(-0.3 * np.maximum(t - 8.0, 0.0))
    return t, PEAK * shaken / np.abs(shaken).max()


def frames(contact: vi.Spring | vi.Newton) -> vi.Scene:
    """Return both buildings with a law between their roofs."""
    w = 2.0 * np.pi * np.array(HERTZ)
    system = vi.LinearSystem(MASS * np.ones(2), 2.0 * RATIO * MASS * w, MASS * w**2, influence=np.ones(2))
    return vi.Scene(system, vi.BaseAcceleration(record()), vi.Stop([1.0, -1.0], ROOM, contact=contact))


def bumper(stiffness: float, release: str) -> vi.Spring:
    """Return the bumper that gives the restitution back to two free roofs, whose reduced mass is half of one."""
    return vi.Spring.from_restitution(RESTITUTION, stiffness, 0.5 * MASS, release=release)


def run(contact: vi.Spring | vi.Newton, **options: object) -> vi.Trajectory:
    """Shake both buildings from rest."""
    return vi.simulate(frames(contact), np.zeros(2), np.zeros(2), (0.0, DURATION), **options)


def ratio(law: vi.Spring) -> float:
    """Return the damping ratio of a bumper between both roofs."""
    return law.damping / (2.0 * np.sqrt(0.5 * MASS * law.stiffness))


def check(law: vi.Spring, pounding: vi.Trajectory) -> None:
    """Compare the run of the dashpot that pulls with steps, its impulses with momentum, its energies with each other."""
    assert abs(ratio(law) - PULLS) < 1e-12
    steps = run(law, method="radau", rtol=1e-10, atol=1e-13)
    first = slice(0, 8)
    off = np.abs(steps.contacts["start"][first] - pounding.contacts["start"][first]).max()
    print(f"the first 8 contacts by the Radau method are off by {off:.0e} s")
    assert off < 1e-7
    hardest = pounding.contacts[np.argmax(pounding.contacts["peak_force"])]
    # A contact is short: its impulse is what the speed changes by times the reduced mass, but for some parts in a hundred.
    taken = 0.5 * MASS * (hardest["speed_before"] + hardest["speed_after"])
    print(f"hardest contact: {hardest['impulse'] / 1e3:.1f} kN s, by the speeds {taken / 1e3:.1f} kN s")
    assert abs(taken / hardest["impulse"] - 1.0) < 0.05
    energy = pounding.energy
    took, closes = energy.contact_loss[-1] / 1e3, np.abs(energy.balance).max() / energy.kinetic.max()
    print(f"the bumper took {took:.1f} kJ, dampers {energy.damping_loss[-1] / 1e3:.1f} kJ; it adds up to {closes:.0e}")
    assert closes < 1e-10
    assert abs(pounding.contacts["loss"].sum() - energy.contact_loss[-1]) < 1e-9 * energy.contact_loss[-1]


def compare() -> dict[str, vi.Trajectory]:
    """Print what differs from law to law, and return the runs."""
    laws = {release: bumper(BUMPER, release) for release in ("gap", "clipped")}
    runs = {release: run(law) for release, law in laws.items()}
    check(laws["gap"], runs["gap"])
    runs["rigid"] = run(vi.Newton(RESTITUTION))
    print("\nlaw        damping ratio  contacts  largest force [MN]  pull [MN]  largest displacements [mm]")
    t = np.linspace(0.0, DURATION, 16001)
    for name, motion in runs.items():
        largest = "  ".join(f"{1e3 * np.abs(motion.along(k, t)).max():6.2f}" for k in (0, 1))
        if name == "rigid":
            print(f"{name:9}  {'-':13}  {len(motion.impacts):<8}  {'-':18}  {'-':9}  {largest}")
            continue
        forces = np.concatenate([force(motion, each, laws[name])[1] for each in motion.contacts])
        pull = max(0.0, -forces.min()) / 1e6
        counts = f"{name:9}  {ratio(laws[name]):<13.4f}  {len(motion.contacts):<8}"
        print(f"{counts}  {forces.max() / 1e6:<18.3f}  {pull:<9.3f}  {largest}")
        assert (pull > 0.1) == (name == "gap"), "one dashpot pulls"
    return runs


def near_rigid(rigid: vi.Trajectory) -> None:
    """Print how stiffer bumpers come near to rigid roofs: by the root of the stiffness, until the second impact."""
    t = np.linspace(0.0, rigid.impacts["time"][1] - 0.02, 400)
    print("\nstiffness [N/m]  largest difference from rigid roofs [mm]")
    differences = []
    for factor in (1.0, 1e2, 1e4):
        motion = run(bumper(BUMPER * factor, "gap"))
        differences.append(1e3 * np.abs(motion.position(t) - rigid.position(t)).max())
        print(f"{BUMPER * factor:<15.0e}  {differences[-1]:.5f}")
    for coarse, fine in pairwise(differences):
        assert 6.0 < coarse / fine < 14.0


def force(motion: vi.Trajectory, contact: np.void, law: vi.Spring) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the bumper is pressed along a contact and its force."""
    end = contact["end"] if np.isfinite(contact["end"]) else motion.t_end
    t = np.linspace(contact["start"], end, 200)[1:-1]
    pressed, speed = motion.along([1.0, -1.0], t) - ROOM, np.diff(motion.velocity(t)[:, ::-1])[:, 0]
    pushed = law.stiffness * pressed + law.damping * speed
    return pressed, np.maximum(pushed, 0.0) if law.release == "clipped" else pushed


def draw(runs: dict[str, vi.Trajectory], output: Path) -> None:
    """Draw the roofs above the force, and the hardest contact by both laws."""
    figure, axes = plt.subplot_mosaic([["roofs", "roofs"], ["force", "loop"]], figsize=(9.0, 6.5), layout="constrained")
    t = np.linspace(0.0, DURATION, 4001)
    for k, color in ((0, "#1d3a66"), (1, "#b8503f")):
        axes["roofs"].plot(t, 1e3 * runs["gap"].along(k, t), color=color, label=f"{HERTZ[k]:g} Hz", linewidth=0.9)
    axes["roofs"].set(xlabel="time [s]", ylabel="roofs [mm]", xlim=(0.0, DURATION))
    axes["roofs"].legend(loc="upper right")
    contacts = runs["gap"].contacts
    axes["force"].vlines(contacts["start"], 0.0, contacts["peak_force"] / 1e6, color="#1d3a66")
    axes["force"].set(xlabel="time [s]", ylabel="largest force of each contact [MN]", xlim=(0.0, DURATION))
    for release, color in (("gap", "#1d3a66"), ("clipped", "#b8503f")):
        motion = runs[release]
        hardest = motion.contacts[np.argmax(motion.contacts["peak_force"])]
        pressed, pushed = force(motion, hardest, bumper(BUMPER, release))
        axes["loop"].plot(1e3 * pressed, pushed / 1e6, color=color, label=f'release="{release}"')
    axes["loop"].axhline(0.0, color="0.7", linewidth=0.8)
    axes["loop"].set(xlabel="approach [mm]", ylabel="force [MN]", title="Hardest contact")
    axes["loop"].legend()
    figure.savefig(output / "pounding_frames.png", dpi=130)


def main() -> None:
    """Shake, compare, draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    runs = compare()
    near_rigid(runs["rigid"])
    draw(runs, output)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
