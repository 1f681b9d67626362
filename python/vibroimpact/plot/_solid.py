"""Artists of animations that are empty until a frame gives them a place: lines of stops and flashes of impacts."""

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vibroimpact.plot._axes import WALL_COLOUR, WALL_WIDTH, solid_side

FLASH_COLOUR = "#e8471c"
FLASH_RIM = 10.0  # wider than the mark that flashes by [points]
FLASH_LABEL = "_flash"


def draw_solid(ax: Axes, left: bool | None, label: str) -> Line2D:
    """Make the line of a stop, with ticks on its solid side (None: no ticks)."""
    effects = [] if left is None else solid_side(left)
    return ax.plot([], [], color=WALL_COLOUR, linewidth=WALL_WIDTH, label=label, zorder=1.5, path_effects=effects)[0]


def draw_flash(ax: Axes, mark: Line2D) -> Line2D:
    """Make the flash of a stop behind the mark of what hits it; its alpha says how brightly it shines."""
    size = mark.get_markersize() + FLASH_RIM
    return ax.plot(
        [], [], linestyle="none", marker="o", markersize=size, color=FLASH_COLOUR, alpha=0.0, label=FLASH_LABEL, zorder=2.5
    )[0]
