"""Several rovers as agents, turn by turn as their missions are: `hopper.pettingzoo.env(scenario="coverage")`.

An agent is a rover, `robot_0` and so on. It is the turn of the rover whose simulated clock is least. Actions are 0 hold, 1 north,
2 east, 3 south, 4 west; what the guard vetoes, or would lead into an occupied cell, is a hold. Whatever else is given for an action
is refused before any rover moves.

An observation is an array of 32-bit floats of shape (6, height, width), the same for all rovers but for the last plane, rows
from south to north: seen, passable, impassable (0 where unseen), visits, all robots, this robot. The map is that of the last
decision.

The reward is the number of cells that a step has covered first, 0 or 1, for the rover that took it. The mission ends for all
rovers at once: terminated when enough is covered, truncated when they run out of actions.

`reset(seed=S)` begins the mission that `hopper run --seed S` flies: the same actions lead to the same digest, which `flight()`
has once the mission is over. It takes no options. `parallel_env` is the same mission with one action for each rover at a time.

`scenario`, `profile`, `dem` and `nodata` are those of `hopper.run`, by default "coverage". Files are read once: all missions of an
environment, of its copies and of its pickles are over the ground that it was made with.

Environments may be made in one thread and used in another, one at a time. `copy.deepcopy`, `pickle`, `snapshot()` and `restore()` fly the
actions so far again. `render_mode` is "rgb_array" or "human", which needs matplotlib.
"""

from __future__ import annotations

import copy
import dataclasses

import gymnasium
import numpy as np
from pettingzoo import AECEnv
from pettingzoo.utils.conversions import turn_based_aec_to_parallel_wrapper

from . import _arguments, _flight, _native, _scene
from ._native import HopperError

__all__ = ["HopperAECEnv", "HopperParallelEnv", "Snapshot", "env", "parallel_env"]

#: Random seeds of missions are below it.
_SEEDS = 2**63

#: Hold and four steps.
_ACTIONS = 5

#: What belongs to the mission in flight, and is had again by flying it again.
_IN_FLIGHT = ("_session", "_due", "_planes", "_robots")


def env(**arguments):
    """The environment of `HopperAECEnv`."""
    return HopperAECEnv(**arguments)


def parallel_env(**arguments):
    """The parallel form: each step gives the rover whose turn it is its action."""
    return HopperParallelEnv(HopperAECEnv(**arguments))


class _NotBegun(HopperError, AttributeError):
    """What is asked for exists once the mission has begun."""


class _Begun:
    """Says what to do where something is asked for before the first `reset`."""

    #: What there is from then on.
    _from_reset = ("agents", "num_agents")

    def __getattr__(self, name):
        if name in self._from_reset:
            raise _NotBegun("the mission is not begun: call reset()")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """A moment of an environment, from `snapshot()`. It can be pickled, and restored in any environment of its scenario.

    Attributes:
        scenario: Name, profile and hash of the scenario.
        seed: The seed of the mission.
        actions: The actions so far.
        agents: What the environment says of its agents: rewards, ends, whose turn it is.
        random: The state of the generator that draws seeds.
    """

    scenario: str
    seed: int
    actions: tuple
    agents: dict
    random: dict


class HopperAECEnv(_Begun, AECEnv):
    """A mission of several rovers; see the module."""

    _from_reset = (*_Begun._from_reset, "agent_selection", "rewards", "terminations", "truncations", "infos")

    metadata = {
        "name": "planetary_hopper_v1", "render_modes": ["human", "rgb_array"], "render_fps": 5, "is_parallelizable": True
    }

    def __init__(self, *, scenario=None, profile=None, dem=None, nodata=None, render_mode=None):
        super().__init__()
        self._window = None
        self.render_mode = _scene.checked(render_mode)
        default = "coverage" if scenario is None and dem is None else scenario
        self._mission = _arguments.mission(default, profile, dem, nodata)
        self._scenario = self._mission.identity
        self._random = np.random.default_rng()
        self._closed, self._seed, self._actions, self._flight = False, None, [], None
        self._fly(0)
        brief = self._due[0]
        self.possible_agents = [f"robot_{number}" for number in range(brief.robots)]
        high = np.ones((6, brief.height, brief.width), "f4")
        high[3] = np.iinfo("u2").max
        space = gymnasium.spaces.Box(np.zeros_like(high), high, dtype=np.float32)
        self.observation_spaces = dict.fromkeys(self.possible_agents, space)
        self.action_spaces = {agent: gymnasium.spaces.Discrete(_ACTIONS) for agent in self.possible_agents}

    def observation_space(self, agent):
        return self.observation_spaces[self._agent(agent)]

    def action_space(self, agent):
        return self.action_spaces[self._agent(agent)]

    def reset(self, seed=None, options=None):
        """Begins a mission: that of `seed`, or a random one."""
        self._check_open()
        _check_options(options)
        if seed is not None:
            seed = _arguments.seed(seed)
            self._random = np.random.default_rng(seed)
        self._fly(int(self._random.integers(_SEEDS)) if seed is None else seed)
        self._flight, self._actions = None, []
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos = {agent: {} for agent in self.agents}
        self.agent_selection = self.agents[self._due[2].robot]
        if self.render_mode == "human":
            self.render()

    def step(self, action):
        """Takes the action of `agent_selection`; None once the mission is over."""
        self._check_begun()
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            if action is not None:
                raise HopperError(f"the mission is over for {agent}: its action needs to be None, got {_arguments.told(action)}")
            self._was_dead_step(action)
            return
        action = _action(action)
        covered = self._due[2].visits
        self._act(action)
        self._actions.append(action)
        self._cumulative_rewards[agent] = 0.0
        self.rewards = dict.fromkeys(self.agents, 0.0)
        if self._due is None:
            self._flight = _flight.flight(*self._session.ended())
            covered_now = int(self._flight.rows["visits"][-1])
            reached = self._flight.summary["outcome"] == "goal"
            ends = self.terminations if reached else self.truncations
            ends.update(dict.fromkeys(self.agents, True))
        else:
            covered_now = self._due[2].visits
            self.agent_selection = self.possible_agents[self._due[2].robot]
        self.rewards[agent] = float(covered_now - covered)
        self._accumulate_rewards()
        if self._due is None:
            self._deads_step_first()
        if self.render_mode == "human":
            self.render()

    def observe(self, agent):
        """The planes as `agent` sees them."""
        agent = self._agent(agent)
        self._check_begun()
        planes = self._planes.copy()
        x, y = self._robots[self.possible_agents.index(agent)]
        planes[5, y, x] = 1.0
        return planes

    def render(self):
        """With "rgb_array" an image of the mission so far; with "human" it is shown in a window."""
        if self.render_mode is None:
            return None
        self._check_begun()
        seen, passable, impassable, visits = self._planes[:4]
        frame = _scene.Frame(_scene.ground(np.where(visits > 0, 1.0, passable * 0.4), np.zeros_like(seen), impassable, seen))
        for number, cell in enumerate(self._robots):
            frame.mark(cell, _scene.ROBOTS[number % len(_scene.ROBOTS)])
        image = frame.image()
        if self.render_mode == "rgb_array":
            return image
        if self._window is None:
            self._window = _scene.Window(f"PlanetaryHopper {id(self):x}")
        return self._window.show(image)

    def flight(self):
        """The mission as `hopper.run` returns it, once it is over; None before."""
        return self._flight

    def snapshot(self):
        """This moment, to come back to with `restore`."""
        self._check_begun()
        names = ("agents", "rewards", "_cumulative_rewards", "terminations", "truncations", "infos", "agent_selection")
        agents = {name: copy.deepcopy(self.__dict__[name]) for name in (*names, "_skip_agent_selection") if name in self.__dict__}
        random = copy.deepcopy(self._random.bit_generator.state)
        return Snapshot(self._scenario, self._seed, tuple(self._actions), agents, random)

    def restore(self, snapshot):
        """Goes back to the moment of `snapshot()`. What it does not fit changes nothing."""
        self._check_open()
        if not isinstance(snapshot, Snapshot):
            raise HopperError(f"restore needs what snapshot() returned, got {_arguments.told(snapshot)}")
        if snapshot.scenario != self._scenario:
            raise HopperError(f"a snapshot needs to be of this scenario, {self._scenario}, got one of {snapshot.scenario}")
        other = self._again(snapshot)
        other._random.bit_generator.state = snapshot.random
        other.__dict__.update(copy.deepcopy(snapshot.agents))
        self.__dict__.pop("_skip_agent_selection", None)
        self.__dict__.update({**other.__dict__, "_window": self._window})

    def close(self):
        """Drops the mission."""
        if self._window is not None:
            self._window.close()
        self._window, self._closed = None, True
        self.__dict__.update(dict.fromkeys(_IN_FLIGHT))

    def __copy__(self):
        # Two environments of one mission would move each other's rovers.
        return copy.deepcopy(self)

    def __getstate__(self):
        return {name: value for name, value in self.__dict__.items() if name not in _IN_FLIGHT}

    def __setstate__(self, state):
        self.__dict__.update(state)
        self.__dict__.update(dict.fromkeys(_IN_FLIGHT))
        if not self._closed:
            self._fly(0 if self._seed is None else self._seed)
            self._seed = state["_seed"]
            self._repeat(self._actions)

    def _again(self, snapshot):
        """A fresh environment of that seed after those actions."""
        fresh = object.__new__(type(self))
        fresh.__dict__.update({name: value for name, value in self.__dict__.items() if name not in _IN_FLIGHT})
        fresh._random = copy.deepcopy(self._random)
        fresh._fly(_arguments.seed(snapshot.seed))
        fresh._actions, fresh._flight = [_action(action) for action in snapshot.actions], None
        fresh._repeat(fresh._actions)
        return fresh

    def _repeat(self, actions):
        for action in actions:
            if self._due is None:
                raise HopperError("a snapshot needs actions until the mission's end, got more")
            self._act(action)
        if self._due is None and self._flight is None:
            self._flight = _flight.flight(*self._session.ended())

    def _fly(self, seed):
        """Begins the mission of `seed` in place of the one before."""
        session = _native.Session(self._mission, seed)
        due = session.next()
        if due is None:
            raise HopperError(f"the mission is over before its first decision: {_flight.flight(*session.ended()).summary['outcome']}")
        self._session, self._due, self._seed = session, due, seed
        self._look()

    def _act(self, action):
        """Takes an action, or holds where the guard vetoes it."""
        decision = self._due[2].decision
        self._session.act(action + 4 if action else 0)
        self._due = self._session.next()
        while self._due is not None and self._due[2].decision == decision:
            self._session.act(0)
            self._due = self._session.next()
        if self._due is not None:
            self._look()

    def _look(self):
        brief, map, state = self._due
        planes = np.zeros((6, brief.height, brief.width), "f4")
        planes[0], planes[1] = map.seen, map.seen & map.passable
        planes[2], planes[3] = map.seen & ~map.passable, map.visits
        for x, y in state.robots:
            planes[4, y, x] = 1.0
        self._planes, self._robots = planes, state.robots

    def _agent(self, agent):
        if agent not in self.possible_agents:
            raise HopperError(f"an agent needs to be one of {', '.join(self.possible_agents)}, got {_arguments.told(agent)}")
        return agent

    def _check_open(self):
        if self._closed:
            raise HopperError("the environment is closed: make another one")

    def _check_begun(self):
        self._check_open()
        if "agent_selection" not in self.__dict__:
            raise HopperError("the mission is not begun: call reset()")


class HopperParallelEnv(_Begun, turn_based_aec_to_parallel_wrapper):
    """The same mission with an action for every rover at a time, of which the rover takes its own whose turn it is."""

    def step(self, actions):
        """Takes the action of the rover whose turn it is; where any action is refused, none."""
        self.aec_env._check_begun()
        if self.agents:
            if not isinstance(actions, dict):
                raise HopperError(f"actions need to be a dictionary by agent, got {_arguments.told(actions)}")
            missing = [agent for agent in self.agents if agent not in actions]
            strange = [agent for agent in actions if agent not in self.possible_agents]
            if missing or strange:
                raise HopperError(f"actions need one of each of {', '.join(self.agents)}, got {_arguments.told(list(actions))}")
            for action in actions.values():
                _action(action)
        return super().step(actions)

    def snapshot(self):
        """This moment, to come back to with `restore`."""
        return self.aec_env.snapshot()

    def restore(self, snapshot):
        """Goes back to the moment of `snapshot()`. What it does not fit changes nothing."""
        self.aec_env.restore(snapshot)
        self.agents = self.aec_env.agents

    def flight(self):
        """The mission as `hopper.run` returns it, once it is over; None before."""
        return self.aec_env.flight()

    def __copy__(self):
        return copy.deepcopy(self)


def _check_options(options):
    if isinstance(options, dict):
        # pettingzoo's API test gives this one to every environment.
        options = {name: value for name, value in options.items() if name != "options"}
    _arguments.options(options)


def _action(action):
    """The code of an action of the action space."""
    if isinstance(action, np.ndarray) and action.shape == () and action.dtype.kind in "iu":
        action = action[()]
    return _arguments.integer("an action", action, 0, _ACTIONS - 1)
