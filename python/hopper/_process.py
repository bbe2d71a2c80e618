"""A planner as a process of an instance."""

from __future__ import annotations

import os

import numpy as np

from . import _arguments, _native
from ._native import HopperError

#: Robots of a mission at most.
_ROBOTS_MAX = 16


def fly(planner, *, instance=None, robot=None, takeover=False, stay=False, wait=None, timeout=5.0):
    """Joins an instance as a planner process and flies until its mission ends.

    `planner` has a method `decide(brief, map, state)` that returns an `Action`, and perhaps a `name`. The process stands by
    while another planner commands, unless `takeover`. `robot` is a number or several; by default HOPPER_ROBOT, else 0.
    `instance` is by default HOPPER_INSTANCE, else "hopper". With `stay` it serves the next mission too; `wait` is how many
    seconds it waits for a peer (None: for ever).

    It commands hoppers, and rovers that cover ground. Of a mission whose robots go along announced routes the log says that
    the planner does not suit it, and it waits for another one.

    Where `decide` raises an exception, returns something else, or takes longer than `timeout` seconds, standard error says so
    and the robot holds. A signal interrupts `decide` by KeyboardInterrupt, which ends the flight, as SystemExit does: nothing is
    commanded for that decision. SystemExit is raised here. Where `decide` forks, the mission stays with the parent: a child that
    returns from it gets a HopperError here.

    Returns the exit code of the process: 0 at the end of the mission, 130 if it was interrupted.
    """
    environment = os.environ.get
    successor = environment("HOPPER_SUCCEEDS_PID")
    return _native.fly(
        planner,
        instance=_arguments.text("an instance", environment("HOPPER_INSTANCE", "hopper") if instance is None else instance),
        robots=_robots(environment("HOPPER_ROBOT", "0") if robot is None else robot),
        takeover=bool(takeover),
        stay=bool(stay),
        wait_s=None if wait is None else _arguments.number("wait", wait, least=0),
        timeout_s=_arguments.number("timeout", timeout, least=0),
        lifeline=environment("HOPPER_LIFELINE") == "true",
        succeeds_pid=_pid(successor) if successor else None,
    )


def _robots(robot):
    wrong = HopperError(f"robots are numbers from 0 to {_ROBOTS_MAX - 1}, got {_arguments.told(robot)}")
    try:
        robot = robot.split(",") if isinstance(robot, str) else robot
        several = [robot] if np.ndim(robot) == 0 and not hasattr(robot, "__iter__") else list(robot)
        numbers = [int(one) if isinstance(one, str) else _arguments.integer("a robot", one, 0, _ROBOTS_MAX - 1) for one in several]
    except (TypeError, ValueError, HopperError):
        raise wrong from None
    if not numbers or any(not 0 <= number < _ROBOTS_MAX for number in numbers):
        raise wrong
    return numbers


def _pid(text):
    try:
        return _arguments.integer("HOPPER_SUCCEEDS_PID", int(text), 0, 2**32 - 1)
    except ValueError:
        raise HopperError(f"HOPPER_SUCCEEDS_PID needs the number of a process, got {text!r}") from None


def check(make):
    """Holds a hopper's planner to the law, by practice missions: `hopper.check(MyPlanner)`.

    `make()` returns a fresh planner. Raises HopperError with the rule that was broken, what was needed and what was got. The
    rules are those of `planner::conformance::check`: an empty cache and a restart change nothing, vetoed actions are not
    commanded, ties go to the first of north, east, south, west. What `decide` raises is raised here.
    """
    if not callable(make):
        raise HopperError(f"check needs a callable that returns a fresh planner, got {_arguments.told(make)}")
    _native.check(make)
