"""What the package promises without a running mission; prints digests as JSON. Run by tests/python.rs."""

import copy
import dataclasses
import importlib.metadata
import inspect
import json
import pickle
import pydoc
import re
import sys

import numpy as np

import hopper

sys.path.insert(0, sys.argv[1])
from planner_python import MyPlanner


def raises(kind, text, call, *arguments, **named):
    try:
        call(*arguments, **named)
    except kind as error:
        assert text in str(error), f"need {text!r} in {str(error)!r}"
        return
    raise AssertionError(f"need {kind.__name__} with {text!r}")


class Watching(MyPlanner):
    """Compares the arrays of each decision with those before."""

    name = "my_planner"
    seen = 0
    cells = []

    def decide(self, brief, map, state):
        shape = (brief.height, brief.width)
        for name, kind, layers in [
            ("height_m", "f8", ()), ("gradient", "f8", (2,)), ("sand", "?", ()), ("passable", "?", ()), ("seen", "?", ()),
            ("visits", "u2", ()),
        ]:
            array = getattr(map, name)
            assert array.shape == shape + layers and array.dtype == np.dtype(kind), (name, array.shape, array.dtype)
            raises(ValueError, "read-only", array.fill, 0)
        assert (np.isnan(map.height_m) == ~map.seen).all() and (np.isnan(map.gradient[..., 0]) == ~map.seen).all()
        assert not (map.sand | map.passable)[~map.seen].any()
        x, y = state.cell
        assert map.seen[y, x] and map.height_m[y, x] == state.height_m
        assert map.seen.sum() >= self.seen
        self.seen = int(map.seen.sum())
        self.cells.append(state.cell)
        assert state.decision == len(self.cells) - 1 and json.loads(state.json())[0]["steps"] == state.steps
        goal = json.loads(brief.json())["robots"][0]["goal"]["reach"]["at"]
        assert [int(goal[side] / brief.cell_size_m) for side in ("x_m", "y_m")] == list(brief.goal)
        return super().decide(brief, map, state)


def lockstep():
    flight = hopper.run("hard", Watching(), seed=3)
    again = hopper.run("hard", MyPlanner(), seed=3)
    assert flight.digest == again.digest, "the name of a planner has no part in a digest"
    rows, route = flight.rows, flight.route
    assert flight.summary["decisions"] == len(rows["decision"]) == len(route["x"]) - 1
    assert list(zip(route["x"][:-1], route["y"][:-1])) == Watching.cells
    assert (rows["decision"] == np.arange(len(rows["decision"]))).all()
    assert rows["steps"][-1] == flight.summary["steps"]
    assert flight.map["seen"].mean() == flight.summary["coverage"]
    assert np.isnan(flight.map["height_m"][~flight.map["seen"]]).all()
    return flight.digest


class Sweeping:
    """A rover's planner: to the free neighbour that was visited least."""

    def decide(self, brief, map, state):
        def is_free(step):
            cell = brief.target(state.cell, step)
            return cell and step not in state.vetoed and cell not in state.robots and map.passable[cell[1], cell[0]]

        def visits(step):
            x, y = brief.target(state.cell, step)
            return map.visits[y, x]

        return min(filter(is_free, hopper.STEPS), key=visits, default=hopper.Action.HOLD)


def rovers():
    flight = hopper.run("coverage", Sweeping(), seed=1)
    assert flight.summary["decisions"] > 100 and flight.map["visits"].max() >= 1
    assert set(flight.rows["robot"]) == {0, 1, 2, 3}


class Raising(MyPlanner):
    def __init__(self, answer):
        self.answer = answer

    def decide(self, brief, map, state):
        if state.decision == 2:
            return self.answer()
        return super().decide(brief, map, state)


def errors():
    raises(ZeroDivisionError, "division", hopper.run, "hard", Raising(lambda: 1 / 0))
    for answer in ["north", None, 9, 2.5, hopper.Action.STEP_NORTH]:
        raises(hopper.HopperError, "decide needs to return a hopper.Action, here HOLD or a hop", hopper.run, "hard",
               Raising(lambda: answer))
    raises(hopper.HopperError, "a planner is a name or has a method decide", hopper.run, "hard", object())
    raises(hopper.HopperError, "a planner needs a method decide", hopper.fly, object())
    for call in (lambda: hopper.run("hard", MyPlanner), lambda: hopper.fly(MyPlanner), lambda: hopper.check(lambda: MyPlanner)):
        raises(hopper.HopperError, "needs to be an instance, got the class MyPlanner: write MyPlanner()", call)
    raises(hopper.HopperError, "no planner is called \"oracle\"", hopper.run, "hard", "oracle")
    raises(hopper.HopperError, "scenario hard needs one of the planners", hopper.run, "hard", "cover_frontier")
    raises(hopper.HopperError, "nowhere", hopper.run, "nowhere")
    raises(hopper.HopperError, "a profile is", hopper.run, "hard", profile="paper")
    raises(hopper.HopperError, "robots are numbers", hopper.fly, MyPlanner(), robot=16)
    try:
        hopper.fly(MyPlanner(), instance=sys.argv[2], wait=0.2)
    except hopper.HopperError as error:
        assert error.exit_code == 4 and "hopper-sim" in str(error), error
    else:
        raise AssertionError("nobody is there")


def keeping(kind):
    """A planner of that kind which keeps copies of what it is given, made in each way."""
    class Keeping(kind):
        def decide(self, brief, map, state):
            given = brief, map, state
            for thing in given:
                text = repr(thing)
                assert text.startswith(f"<{type(thing).__name__} of ") and "\n" not in text and len(text) < 200, text
            if state.decision == 4:
                self.told = brief.json(), state.json(), repr(map), map.fingerprint
                self.arrays = map.seen.copy(), map.height_m.copy(), map.visits.copy()
                self.copies = [tuple(copy.copy(thing) for thing in given), copy.deepcopy(given), pickle.loads(pickle.dumps(given))]
            return super().decide(brief, map, state)

    return Keeping()


def kept():
    """Copies and pickles of brief, map and state are those of their decision."""
    for scenario, kind in [("hard", MyPlanner), ("coverage", Sweeping)]:
        planner = keeping(kind)
        hopper.run(scenario, planner, 3)
        for brief, map, state in planner.copies:
            assert (brief.json(), state.json(), repr(map), map.fingerprint) == planner.told
            for array, expected in zip((map.seen, map.height_m, map.visits), planner.arrays):
                assert array.dtype == expected.dtype and np.array_equal(array, expected, equal_nan=array.dtype.kind == "f")
            assert state.decision == 4 and brief.target(state.cell, 0) == state.cell


def compared():
    """What holds arrays is compared by its contents, and shown in a line."""
    zeros = np.zeros((20, 20))
    worlds = [hopper.World(zeros + at, np.eye(20, dtype=bool), zeros) for at in (0, 0, 1)]
    solutions = [hopper.solve(world) for world in worlds[:2]]
    assert worlds[0] == worlds[1] != worlds[2] and worlds[1] in worlds[:1] and solutions[0] == solutions[1] != worlds[0]
    assert hopper.World(zeros * np.nan, 0, 0) == hopper.World(zeros * np.nan, 0, 0) != hopper.World(zeros, 0, 0)
    assert hopper.World([[1, 2], [3]], 0, 0) != hopper.World("x", 0, 0) and hopper.World(0, 0, 0) != 5
    flight = hopper.run("hard", "greedy", 3)
    for thing in (*worlds, *solutions, flight):
        assert "\n" not in repr(thing) and len(repr(thing)) < 400, repr(thing)
    assert repr(flight) == f"<Flight of scenario hard, seed 3: {flight.summary['outcome']}, " \
        f"{flight.summary['decisions']} decisions, digest {flight.digest}>", repr(flight)


def metadata():
    """The wheel says what the package is and how it is licensed."""
    about = importlib.metadata.metadata("hopper-autonomy")
    assert about["License-Expression"] == "Apache-2.0 OR MIT" and about["Summary"] and "hopper.run(" in about.get_payload()
    names = {file.name for file in importlib.metadata.files("hopper-autonomy")}
    assert {"LICENSE-APACHE", "LICENSE-MIT"} <= names, names


class EastFirst(MyPlanner):
    """Breaks the rule of ties."""

    def decide(self, brief, map, state):
        x, y = state.cell
        if brief.goal[0] > x and not {2} & set(state.vetoed):
            return hopper.Action.EAST
        return super().decide(brief, map, state)


class Forgetful(MyPlanner):
    """Breaks the rule of the empty cache."""

    decisions = 0

    def decide(self, brief, map, state):
        self.decisions += 1
        return hopper.Action.HOLD if self.decisions > 1 and state.decision == 1 else super().decide(brief, map, state)


def law():
    hopper.check(MyPlanner)
    raises(hopper.HopperError, "breaks the law (ties)", hopper.check, EastFirst)
    raises(hopper.HopperError, "breaks the law (empty cache)", hopper.check, Forgetful)
    raises(ZeroDivisionError, "division", hopper.check, lambda: Raising(lambda: 1 / 0))
    raises(hopper.HopperError, "a planner needs a method decide", hopper.check, object)


def value_iteration(world):
    """Values by the definition of the solver's documentation, in plain NumPy."""
    height, width = world.payoff.shape
    steps = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    values = np.zeros_like(world.payoff)
    intended, stuck, sideways, wait = world.soils[0]
    assert stuck == 0 and wait == 0
    y, x = np.mgrid[0:height, 0:width]

    def landing(step):
        to_y, to_x = y + step[0], x + step[1]
        inside = (0 <= to_y) & (to_y < height) & (0 <= to_x) & (to_x < width)
        to_y, to_x = np.where(inside, to_y, y), np.where(inside, to_x, x)
        after = np.where(world.goal, world.payoff, np.where(world.lost, world.loss, world.payoff + values))
        return after[to_y, to_x]

    for _ in range(4000):
        landings = [landing(step) for step in steps]
        hops = [
            world.discount * (intended * landings[u] + sideways * (landings[u - 1] + landings[(u + 1) % 4])) for u in range(4)
        ]
        values = np.where(world.goal | world.lost, 0.0, np.max(hops, axis=0))
    return values


def solver():
    random = np.random.default_rng(7)
    shape = (13, 17)
    payoff = -random.random(shape)
    goal = np.zeros(shape, bool)
    goal[11, 14] = True
    payoff[goal] = 100.0
    lost = (random.random(shape) < 0.1) & ~goal
    world = hopper.World(payoff, goal, lost, discount=0.97, loss=-20.0)
    solution = hopper.solve(world, error_max=1e-9)
    values, policy, bound = solution
    free = ~goal & ~lost
    assert solution.is_solved and 0 < bound <= 1e-9 and solution.sweeps > 0
    assert np.abs(values - value_iteration(world))[free].max() <= 1e-8
    assert set(policy[free]) <= {1, 2, 3, 4} and not policy[~free].any()
    raises(hopper.HopperError, "discount", hopper.solve, hopper.World(payoff, goal, lost, discount=1.0))
    raises(hopper.HopperError, "goal needs shape (13, 17)", hopper.solve, hopper.World(payoff, goal[1:], lost))
    for leaving, got in [("flies", '"flies"'), ("", '""'), (None, "None")]:
        raises(hopper.HopperError, f'leaving needs to be "stays" or "loses", got {got}', hopper.solve,
               hopper.World(payoff, goal, lost, leaving=leaving))
    raises(hopper.HopperError, "finite payoff", hopper.solve, hopper.World(payoff * np.nan, goal, lost))
    assert not hopper.solve(world, error_max=1e-300).is_solved


def documented():
    for name in hopper.__all__:
        assert inspect.getdoc(getattr(hopper, name)) or name in ("HOPS", "STEPS", "__version__"), f"{name} has no docstring"
    assert set(dir(hopper)) == set(hopper.__all__) and re.fullmatch(r"\d+\.\d+\.\d+", hopper.__version__)
    for kind in (hopper.World, hopper.Solution, hopper.Flight, hopper.Journal, hopper.Recording):
        text = pydoc.render_doc(kind, renderer=pydoc.plaintext)
        assert f"class {kind.__name__} in module hopper" in text, text[:200]
        for field in dataclasses.fields(kind):
            assert field.name.startswith("_") or f"    {field.name}: " in inspect.getdoc(kind), f"{kind.__name__}.{field.name}"
    for kind in (hopper.Brief, hopper.State, hopper.Map):
        for name, member in vars(kind).items():
            assert name.startswith("_") or inspect.getdoc(member), f"{kind.__name__}.{name} has no docstring"


def own_planners():
    """A planner of one's own flies what it suits, and is refused by name elsewhere; without one the scenario's own fly."""
    assert hopper.run("hopper-scout", MyPlanner()).summary["decisions"] > 10
    for planner in (MyPlanner(), Sweeping(), Raising(lambda: hopper.Action.HOLD)):
        name = type(planner).__name__
        for scenario in ("rover-helicopter", "expedition"):
            raises(hopper.HopperError, f"got {name}, a planner of your own", hopper.run, scenario, planner)
            raises(hopper.HopperError, f"scenario {scenario} needs", hopper.run, scenario, planner)

    class Same(MyPlanner):
        name = "scout_ahead"

    raises(hopper.HopperError, "different names", hopper.run, "hopper-scout", Same())
    return {scenario: hopper.run(scenario).digest for scenario in ("hopper-scout", "rover-helicopter", "coverage", "expedition")}


def pictures():
    flight = hopper.run("treasures", "mdp", 1)
    picture = flight._repr_svg_()
    assert picture.startswith("<svg") and picture.rstrip().endswith("</svg>") and len(picture) > 10_000
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    axes = flight.plot()
    assert axes.get_xlabel() == "x, cells" and len(axes.lines) >= 2
    _, other = plt.subplots()
    assert hopper.run("coverage", seed=1).plot(other) is other and len(other.get_legend().texts) == 4
    plt.close("all")


digest = lockstep()
rovers()
errors()
law()
solver()
documented()
kept()
compared()
metadata()
pictures()
print(json.dumps({"mdp": hopper.run("hard", seed=3).digest, "template": digest, "own": own_planners()}))
