"""Hopper for Python: planners of your own, missions in lockstep, the certified solver, journals and recordings.

    import hopper

    class MyPlanner:
        def decide(self, brief, map, state):
            return hopper.Action.HOLD

    hopper.fly(MyPlanner(), instance="hopper")            # joins a running mission
    flight = hopper.run("hard", planner=MyPlanner())      # flies one in this thread

Arrays over a grid are indexed [y, x], row 0 southernmost; cells are pairs (x, y). Units are in the names. Environments for
learners are in `hopper.gym` and `hopper.pettingzoo`.
"""

from ._action import HOPS, STEPS, UPS, Action
from ._flight import Flight, run
from ._native import Brief, DecideTimeout, HopperError, Map, State, __version__
from ._process import check, fly
from ._recorded import Journal, Recording, read_journal, read_recording
from ._solver import Solution, World, solve

__all__ = [
    "Action", "Brief", "DecideTimeout", "Flight", "HOPS", "HopperError", "Journal", "Map", "Recording", "STEPS", "Solution",
    "State", "UPS", "World", "__version__", "check", "fly", "read_journal", "read_recording", "run", "solve",
]

for _public in (Action, Flight, Journal, Recording, Solution, World, check, fly, read_journal, read_recording, run, solve):
    # Where they are imported from, in help texts, tracebacks and pickles.
    _public.__module__ = __name__
del _public


def __dir__():
    return sorted(__all__)
