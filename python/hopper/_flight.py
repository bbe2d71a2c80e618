"""Missions in this thread."""

from __future__ import annotations

import dataclasses
import json

import numpy as np

from . import _arguments, _native
from ._columns import columns
from ._contents import Contents
from ._native import HopperError


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Flight(Contents):
    """A mission that was flown. `==` compares all that it holds, times of planning too; flights of one mission have one digest.

    A notebook shows its picture; `plot()` draws it with matplotlib.

    Attributes:
        summary: The summary of `hopper run --format json`, a dictionary.
        rows: Columns of one row for each decision; `action` holds codes of `Action`.
        route: Columns x, y, robot: the start (of a hopper), then the cell after each decision.
        map: Arrays of the observed map at the end: height_m, seen, sand, passable, visits.
        digest: The digest of the mission, equal for equal missions however they were flown.
    """

    summary: dict
    rows: dict
    route: dict
    map: dict
    _drawing: object = dataclasses.field(default=None, compare=False)

    @property
    def digest(self):
        """The digest of the mission, equal for equal missions however they were flown."""
        return self.summary["digest"]

    def plot(self, ax=None):
        """Draws what was seen, and the route of each robot, into `ax` or a new figure; returns the axes. Needs matplotlib."""
        try:
            import matplotlib.pyplot as plt
        except ImportError:
            raise HopperError("plot() needs matplotlib: pip install matplotlib") from None
        if ax is None:
            _, ax = plt.subplots()
        ground = ax.imshow(self.map["height_m"], origin="lower", cmap="Greys_r")
        ax.figure.colorbar(ground, ax=ax, label="height above the datum, m")
        marked = [("sand", "Oranges"), ("impassable", "Reds")]
        flags = {"sand": self.map["sand"], "impassable": self.map["seen"] & ~self.map["passable"]}
        for name, shades in marked:
            shown = np.ma.masked_where(~flags[name], np.ones(flags[name].shape))
            ax.imshow(shown, origin="lower", cmap=shades, vmin=0, vmax=2, alpha=0.5)
        x, y, robots = (self.route[name] for name in ("x", "y", "robot"))
        for robot in np.unique(robots):
            of_robot = robots == robot
            ax.plot(x[of_robot], y[of_robot], ".-", markersize=4, linewidth=1, label=f"robot {robot}")
            ax.plot(x[of_robot][-1:], y[of_robot][-1:], "o", color=ax.lines[-1].get_color())
        if len(np.unique(robots)) > 1:
            ax.legend()
        ax.set(
            title=f"{self.summary['scenario']}: {self.summary['outcome'].replace('_', ' ')}, {self.summary['decisions']} decisions",
            xlabel="x, cells", ylabel="y, cells",
        )
        return ax

    def __repr__(self):
        scenario, seed, outcome, decisions, digest = (
            self.summary[name] for name in ("scenario", "seed", "outcome", "decisions", "digest")
        )
        return f"<Flight of scenario {scenario}, seed {seed}: {outcome.replace('_', ' ')}, {decisions} decisions, digest {digest}>"

    def _repr_svg_(self):
        return self._drawing if isinstance(self._drawing, (str, type(None))) else self._drawing.svg()

    def __getstate__(self):
        return {**self.__dict__, "_drawing": self._repr_svg_()}

    def __setstate__(self, state):
        self.__dict__.update(state)


def run(scenario=None, planner=None, seed=1, *, profile=None, dem=None, nodata=None):
    """Flies a mission in this thread, without shared memory; the digest is that of the same mission flown live.

    `scenario` is a built-in name or a TOML file; by default "hard", or with `dem` one that fits the elevation model. `planner` is
    the name of a built-in planner for all robots whom it suits, or an object with a method `decide(brief, map, state)`; by
    default those that the scenario names. `profile` is "paper-2023", "hopper", "paper-2022", or None for the scenario's. `dem` is the file of an
    elevation model, in place of the scenario's. `nodata` settles which of its stored values are nodata beside the declared one: a
    number, or several; `[]` for none.

    What `decide` raises is raised here, and ends the mission. A planner that does not suit the mission is refused by name. Other
    threads run meanwhile.
    """
    if planner is not None and not isinstance(planner, str) and not callable(getattr(planner, "decide", None)):
        raise HopperError(f"a planner is a name or has a method decide(brief, map, state), got {_arguments.told(planner)}")
    if isinstance(planner, str):
        planner = _arguments.text("a planner", planner)
    seed = _arguments.seed(seed)
    return flight(*_native.run(_arguments.mission(scenario, profile, dem, nodata), planner, seed))


def flight(summary, shape, rows, route, cells, drawing):
    """The mission that the native half has flown."""
    cells = {name: column.reshape(shape) for name, column in columns(cells).items()}
    return Flight(json.loads(summary), columns(rows), columns(route), cells, drawing)
