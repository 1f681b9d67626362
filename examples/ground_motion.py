"""Two frames that pound against each other in an earthquake.

Two buildings of two storeys stand 20 mm apart: a stiff one of 3 Hz and a soft one of 1.4 Hz, with 3 % damping each. Their
floors are at one height, so that the roofs may hit each other, and the first floors; the gap of a pair is a stop on the
difference of two coordinates. The ground follows a record made by the script as records look: noise through the filter of Kanai
and Tajimi, which has the soil's own frequency, under an envelope, 20 s at 100 samples a second; between samples it is a
straight line, and exact flights follow it from sample to sample.

You will see the record, both roofs with and without the other building, and the impulses of the impacts. The script compares the
first impacts with those by the Radau method, and checks the ledger and the momentum of the whole.

Run: python examples/ground_motion.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

DURATION, RATE = 20.0, 100  # of the record [s], [samples/s]
PEAK = 3.5  # [m/s^2]
ROOM = 0.02  # between the buildings [m]
RESTITUTION = 0.65  # of concrete on concrete
SOIL, SOIL_DAMPING = 2.0 * np.pi * 2.4, 0.6
FLOOR = 4e4  # mass of a floor [kg]


def record() -> tuple[np.ndarray, np.ndarray]:
    """Return times and accelerations like those of a strong earthquake."""
    t = np.arange(int(DURATION * RATE) + 1) / RATE
    noise = np.random.default_rng(40).normal(size=t.size)
    # The absolute acceleration of an oscillator, the soil, on white noise.
    w = 2.0 * np.pi * np.fft.rfftfreq(t.size, 1.0 / RATE)
    filtered = (SOIL**2 + 2j * SOIL_DAMPING * SOIL * w) / (SOIL**2 - w**2 + 2j * SOIL_DAMPING * SOIL * w)
    shaken = np.fft.irfft(np.fft.rfft(noise) * filtered * (w > 2.0 * np.pi * 0.2), t.size)
    envelope = np.minimum(t / 3.0, 1.0) ** 2 * np.exp(-0.3 * np.maximum(t - 8.0, 0.0))
    shaken *= envelope
    return t, PEAK * shaken / np.abs(shaken).max()


def buildings(room: float) -> vi.Scene:
    """Both buildings, floors of the stiff one first; no stops where the room is not finite."""
    storey = np.array([[2.0, -1.0], [-1.0, 1.0]])
    lowest = 0.5 * (3.0 - np.sqrt(5.0))  # of the matrix above
    stiffness, damping = np.zeros((4, 4)), np.zeros((4, 4))
    for k, hertz in ((0, 3.0), (2, 1.4)):
        first = 2.0 * np.pi * hertz
        stiffness[k : k + 2, k : k + 2] = FLOOR * first**2 / lowest * storey
        second = first * np.sqrt(0.5 * (3.0 + np.sqrt(5.0)) / lowest)
        damping[k : k + 2, k : k + 2] = vi.rayleigh_damping(
            FLOOR * np.eye(2), stiffness[k : k + 2, k : k + 2], ratios={first: 0.03, second: 0.03}
        )
    system = vi.LinearSystem(FLOOR * np.ones(4), damping, stiffness, influence=np.ones(4))
    pairs = ([1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0])
    stops = [vi.Stop(normal, room, RESTITUTION) for normal in pairs] if np.isfinite(room) else ()
    return vi.Scene(system, vi.BaseAcceleration(record()), stops)


def main() -> None:
    """Run both with and without each other, check, draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    folder: Path = parser.parse_args().output
    rest = np.zeros(4)
    pounding, apart = (vi.simulate(buildings(room), rest, rest, (0.0, DURATION)) for room in (ROOM, np.inf))
    impacts = pounding.impacts
    by_roof, by_floor = (int(np.sum(impacts["stop"] == stop)) for stop in (1, 0))
    largest = impacts["impulse"].max()
    print(f"{by_roof} impacts of the roofs, {by_floor} of the first floors; the largest impulse {largest:.0f} N s")
    steps = vi.simulate(buildings(ROOM), rest, rest, (0.0, DURATION), method="radau", rtol=1e-9, atol=1e-12, keep="impacts")
    count = min(12, len(impacts))
    off = np.abs(steps.impacts["time"][:count] - impacts["time"][:count]).max()
    print(f"the first {count} impacts by the Radau method are off by {off:.0e} s")
    assert count >= 5
    assert off < 1e-6
    energy = pounding.energy
    closes = np.abs(energy.balance).max() / energy.kinetic.max()
    # The stops push the buildings apart: what one gets, the other loses.
    given = pounding.impulse(1)
    assert abs(given - impacts["impulse"][impacts["stop"] == 1].sum()) < 1e-9 * given
    impacts_took, dampers_took = energy.impact_loss[-1] / 1e3, energy.damping_loss[-1] / 1e3
    print(f"impacts took {impacts_took:.1f} kJ, dampers {dampers_took:.1f} kJ; it adds up to {closes:.0e}")
    assert closes < 1e-11
    assert float(pounding.gap(1).min()) > -1e-12

    figure, axes = plt.subplots(3, 1, figsize=(9, 7), layout="constrained", sharex=True)
    axes[0].plot(*record(), color="0.3", linewidth=0.7)
    axes[0].set_ylabel("ground [m/s\u00b2]")
    t = np.linspace(0.0, DURATION, 4001)
    for coordinate, name, colour in ((1, "stiff", "C0"), (3, "soft", "C1")):
        axes[1].plot(t, 1e3 * apart.along(coordinate, t), color=colour, linewidth=0.6, alpha=0.5, label=f"{name}, alone")
        axes[1].plot(t, 1e3 * pounding.along(coordinate, t), color=colour, linewidth=0.9, label=name)
    axes[1].set_ylabel("roofs [mm]")
    axes[1].legend(ncols=2, fontsize="small")
    for stop, name, colour in ((1, "roofs", "C3"), (0, "first floors", "C2")):
        own = impacts[impacts["stop"] == stop]
        axes[2].vlines(own["time"], 0.0, own["impulse"] / 1e3, color=colour, label=name)
    axes[2].set(xlabel="time [s]", ylabel="impulse [kN s]")
    axes[2].legend()
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "ground_motion.png", dpi=120)
    print(f"figure in {folder}/ground_motion.png")


if __name__ == "__main__":
    main()
