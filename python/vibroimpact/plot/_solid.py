"""Artists of animations that are empty until a frame gives them a place: lines of stops and flashes of impacts."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from vibroimpact.plot._axes import WALL_COLOUR, WALL_WIDTH, solid_side

FLASH_COLOUR = "#e8471c"
FLASH_RIM = 10.0  # wider than the mark that flashes by [points]
FLASH_LABEL = "_flash"


def draw_solid(ax: Axes, left: bool | None, label: str, aside: float = 0.0) -> Line2D:
    """Make the line of a stop, with ticks on its solid side (None: no ticks), drawn so far to the right of its place [points].

    Positions are those of the middle of a mass: half its width aside, the stop is where its face is in contact.
    """
    effects = [] if left is None else solid_side(left)
    assert ax.figure is not None  # axes_or_new refuses Axes without a figure
    place = ax.transData + ScaledTranslation(aside / 72.0, 0.0, ax.figure.dpi_scale_trans)
    options: dict[str, Any] = {"color": WALL_COLOUR, "linewidth": WALL_WIDTH, "zorder": 1.5, "path_effects": effects}
    return ax.plot([], [], label=label, transform=place, **options)[0]


def half_width(mark: Line2D) -> float:
    """Return half the width of a mark and of the line of a stop [points]."""
    return 0.5 * (float(mark.get_markersize()) + float(mark.get_markeredgewidth()) + WALL_WIDTH)


def draw_flash(ax: Axes, mark: Line2D) -> Line2D:
    """Make the flash of a stop behind the mark of what hits it; its alpha says how brightly it shines."""
    size = mark.get_markersize() + FLASH_RIM
    return ax.plot(
        [], [], linestyle="none", marker="o", markersize=size, color=FLASH_COLOUR, alpha=0.0, label=FLASH_LABEL, zorder=2.5
    )[0]
