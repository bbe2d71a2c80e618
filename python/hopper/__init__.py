"""Hopper for Python: planners of your own, missions in lockstep, the certified solver, journals and recordings.

    import hopper

    class MyPlanner:
        def decide(self, brief, map, state):
            return hopper.Action.HOLD

    hopper.fly(MyPlanner(), instance="hopper")            # joins a running mission
    flight = hopper.run("hard", planner=MyPlanner())      # flies one in this thread

Arrays over a grid are indexed [y, x], row 0 southernmost; cells are pairs (x, y). Units are in the names.
"""

from __future__ import annotations

import dataclasses
import enum
import json
import os

import numpy as np

from . import _native
from ._native import Brief, DecideTimeout, HopperError, Map, State

__all__ = [
    "Action", "Brief", "DecideTimeout", "Flight", "HOPS", "HopperError", "Journal", "Map", "Recording", "STEPS", "Solution",
    "State", "World", "check", "fly", "read_journal", "read_recording", "run", "solve",
]


class Action(enum.IntEnum):
    """What a planner may command: hold or a hop; of a rover, hold or a step. Values are the codes on the wire."""

    HOLD = 0
    NORTH = 1
    EAST = 2
    SOUTH = 3
    WEST = 4
    STEP_NORTH = 5
    STEP_EAST = 6
    STEP_SOUTH = 7
    STEP_WEST = 8


#: The hops of a hopper, in the order in which ties are broken.
HOPS = (Action.NORTH, Action.EAST, Action.SOUTH, Action.WEST)

#: The steps of a rover, in the order in which ties are broken.
STEPS = (Action.STEP_NORTH, Action.STEP_EAST, Action.STEP_SOUTH, Action.STEP_WEST)


def fly(planner, *, instance=None, robot=None, takeover=False, stay=False, wait=None, timeout=5.0):
    """Joins an instance as a planner process and flies until its mission ends.

    `planner` has a method `decide(brief, map, state)` that returns an `Action`, and perhaps a `name`. The process stands by
    while another planner commands, unless `takeover`. `robot` is a number or several; by default HOPPER_ROBOT, else 0.
    `instance` is by default HOPPER_INSTANCE, else "hopper". With `stay` it serves the next mission too; `wait` is how many
    seconds it waits for a peer (None: for ever).

    Where `decide` raises an exception, returns something else, or takes longer than `timeout` seconds, standard error says so
    and the robot holds. A signal interrupts `decide` by KeyboardInterrupt, which ends the flight, as SystemExit does: nothing is
    commanded for that decision. SystemExit is raised here.

    Returns the exit code of the process: 0 at the end of the mission, 130 if it was interrupted.
    """
    environment = os.environ.get
    if robot is None:
        robot = [int(number) for number in environment("HOPPER_ROBOT", "0").split(",")]
    robots = [int(robot)] if isinstance(robot, int) else [int(number) for number in robot]
    if not robots or any(not 0 <= number < 16 for number in robots):
        raise HopperError(f"robots are numbers from 0 to 15, got {robot!r}")
    successor = environment("HOPPER_SUCCEEDS_PID")
    return _native.fly(
        planner,
        instance=instance if instance is not None else environment("HOPPER_INSTANCE", "hopper"),
        robots=robots,
        takeover=bool(takeover),
        stay=bool(stay),
        wait_s=wait,
        timeout_s=float(timeout),
        lifeline=environment("HOPPER_LIFELINE") == "true",
        succeeds_pid=int(successor) if successor else None,
    )


@dataclasses.dataclass(frozen=True)
class Flight:
    """A mission that was flown."""

    #: The summary of `hopper run --format json`.
    summary: dict
    #: Columns of one row for each decision; `action` holds codes of `Action`.
    rows: dict
    #: Columns x, y, robot: the start (of a hopper), then the cell after each decision.
    route: dict
    #: Arrays of the observed map at the end: height_m, seen, sand, passable, visits.
    map: dict

    @property
    def digest(self):
        """The digest of the mission, equal for equal missions however they were flown."""
        return self.summary["digest"]


def run(scenario="hard", planner="mdp", seed=1, *, profile=None):
    """Flies a mission in this thread, without shared memory; the digest is that of the same mission flown live.

    `scenario` is a built-in name or a TOML file; `planner` the name of a built-in planner or an object with a method
    `decide(brief, map, state)`; `profile` "paper-2023", "hopper", or None for the scenario's. What `decide` raises is raised
    here, and ends the mission.
    """
    if not isinstance(planner, str) and not callable(getattr(planner, "decide", None)):
        raise HopperError(f"a planner is a name or has a method decide(brief, map, state), got {planner!r}")
    return _flight(*_native.run(os.fspath(scenario), planner, seed, profile))


def _flight(summary, shape, rows, route, cells):
    cells = {name: column.reshape(shape) for name, column in _columns(cells).items()}
    return Flight(json.loads(summary), _columns(rows), _columns(route), cells)


def check(make):
    """Holds a hopper's planner to the law, by practice missions: `hopper.check(MyPlanner)`.

    `make()` returns a fresh planner. Raises HopperError with the rule that was broken, what was needed and what was got. The
    rules are those of `planner::conformance::check`: an empty cache and a restart change nothing, vetoed actions are not
    commanded, ties go to the first of north, east, south, west. What `decide` raises is raised here.
    """
    _native.check(make)


@dataclasses.dataclass(frozen=True)
class World:
    """A grid world of hops, its arrays indexed [y, x]."""

    #: Payoff of landing on a cell.
    payoff: np.ndarray
    #: Cells where the process ends.
    goal: np.ndarray
    #: Cells where the hopper is lost.
    lost: np.ndarray
    #: Slope towards the east and towards the north in slope limits, clamped to [-1, 1].
    slope_east: np.ndarray = 0.0
    slope_north: np.ndarray = 0.0
    #: Index of each cell's soil in `soils`.
    soil: np.ndarray = 0
    #: (intended, stuck, sideways, wait) of each soil: intended + stuck + 2 sideways = 1; `wait` is the share of hops that take a
    #: second period.
    soils: tuple = ((0.9, 0.0, 0.05, 0.0),)
    #: Discount of one period, in [0, 1).
    discount: float = 0.99
    #: What being lost is worth, in units of payoff.
    loss: float = 0.0
    #: Leaving the grid: "stays" or "loses".
    leaving: str = "stays"


@dataclasses.dataclass(frozen=True)
class Solution:
    """Certified values of a world. Unpacks as `values, policy, bound`."""

    #: Value of each cell.
    values: np.ndarray
    #: Best hop of each cell as a code of `Action`; HOLD where there is none to choose.
    policy: np.ndarray
    #: Proven bound on the error of the values.
    bound: float
    #: Whether the bound that was asked for is reached, or the limit of floating point.
    is_solved: bool
    #: Work done.
    sweeps: int

    def __iter__(self):
        return iter((self.values, self.policy, self.bound))


def solve(world, *, error_max=1e-6, sweeps_max=None):
    """Solves a `World` from nothing, to an error of `error_max` in units of payoff or within `sweeps_max` sweeps."""
    shape = np.shape(world.payoff)
    if len(shape) != 2:
        raise HopperError(f"a payoff needs 2 dimensions, got {len(shape)}")

    def flat(name, kind):
        try:
            return np.broadcast_to(np.asarray(getattr(world, name), dtype=kind), shape).ravel().tolist()
        except ValueError as error:
            raise HopperError(f"{name} needs shape {shape}: {error}") from None

    native = _World(
        shape, flat("payoff", "f8"), flat("slope_east", "f8"), flat("slope_north", "f8"), flat("soil", "u1"),
        flat("goal", "?"), flat("lost", "?"), [tuple(soil) for soil in world.soils], world.discount, world.loss, world.leaving,
    )
    columns, bound, is_solved, sweeps = _native.solve(native, error_max, sweeps_max)
    columns = _columns(columns)
    return Solution(columns["values"].reshape(shape), columns["policy"].reshape(shape), bound, is_solved, sweeps)


@dataclasses.dataclass(frozen=True)
class _World:
    shape: tuple
    payoff: list
    slope_east: list
    slope_north: list
    soil: list
    goal: list
    lost: list
    soils: list
    discount: float
    loss: float
    leaving: str


@dataclasses.dataclass(frozen=True)
class Journal:
    """A journal of decisions."""

    seed: int
    digest: str
    #: The brief, every field of it.
    brief: dict
    #: The resolved scenario as TOML.
    scenario: str
    #: As in `Flight`.
    rows: dict
    route: dict


def read_journal(path):
    """Reads a journal, or the journal in the output directory of a run."""
    about, scenario, rows, route = _native.read_journal(os.fspath(path))
    about = json.loads(about)
    return Journal(about["seed"], about["digest"], about["brief"], scenario, _columns(rows), _columns(route))


@dataclasses.dataclass(frozen=True)
class Recording:
    """States and commands of a recording, one row for each message."""

    #: Whether the file is complete, and how many bytes after its last whole record are not.
    is_whole: bool
    lost_bytes: int
    #: Metadata records by name.
    metadata: dict
    #: Number of messages by topic.
    messages: dict
    #: Columns of all states.
    states: dict
    #: Columns of all commands.
    commands: dict


def read_recording(path):
    """Reads an MCAP file of `hopper run --record`, up to its last whole record."""
    about, tables = _native.read_recording(os.fspath(path))
    about = json.loads(about)
    states, commands = _columns(tables["state"]), _columns(tables["command"])
    return Recording(about["whole"], about["lost_bytes"], about["metadata"], about["messages"], states, commands)


def _columns(columns):
    return {name: np.frombuffer(data, dtype=kind) for name, (kind, data) in columns.items()}
