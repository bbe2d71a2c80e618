"""Every public function, method and property with arguments that it cannot have: an error that `except Exception` catches, nothing
moved, nothing hangs. Run by tests/python.rs, with a folder of its own to work in."""

import faulthandler
import gc
import itertools
import json
import math
import os
import pathlib
import struct
import sys
import tempfile
import types
import warnings
import zlib

import gymnasium
import numpy as np

import hopper
import hopper.gym
import hopper.pettingzoo
from hopper import _native

faulthandler.enable()
folder = tempfile.mkdtemp()

#: What no argument of the package can be, or only a few.
STRANGE = [
    None, True, math.nan, math.inf, -math.inf, -1, -1.0, 0.5, 2**31, 2**32, 2**63, 2**64, 2**70, -(2**70), 1e308, 10**400, "", "x",
    "\0", "\ud800", "é" * 300, "a/b", "../x", b"hard", bytearray(b"x"), [], [1], (1, 2), {}, {1: 2}, set(), object(), object, len,
    (number for number in range(3)), iter([]), np.nan, np.float32(2), np.int8(-1), np.uint64(2**63), np.array(3), np.array([3.0]),
    np.array([[1]]), np.zeros(0), np.array(["a"]), np.array([None]), np.arange(6)[::2], np.zeros((2, 2), ">f8"), np.ma.masked,
    np.datetime64("2020"), 1j, range(3), types.SimpleNamespace(shape=(2, 2)), pathlib.Path("x"), memoryview(b"12"), slice(None),
    NotImplemented, ..., ValueError("x"), hopper.Action.NORTH,
]


class Liar:
    """Raises whenever it is looked at."""

    def _raise(self, *arguments):
        raise RuntimeError("looked at")

    __index__ = __int__ = __float__ = __len__ = __iter__ = __repr__ = __str__ = __array__ = __fspath__ = __bool__ = __eq__ = _raise
    __hash__ = None


STRANGE.append(Liar())
calls = 0


def survives(call, *arguments, **named):
    """Whether it was taken; what is raised is an Exception."""
    global calls
    calls += 1
    try:
        call(*arguments, **named)
    except Exception as error:
        assert "defect" not in str(error), error
        return False
    return True


def refused(text, call, *arguments, **named):
    try:
        call(*arguments, **named)
    except hopper.HopperError as error:
        assert text in str(error), f"need {text!r} in {str(error)!r}"
        return
    raise AssertionError(f"need a HopperError with {text!r}")


class Holds:
    def decide(self, brief, map, state):
        return hopper.Action.HOLD


def functions():
    for strange in STRANGE:
        is_planner = isinstance(strange, type(None))
        survives(hopper.run, strange)
        survives(hopper.run, "hard", strange if not is_planner else Liar())
        survives(hopper.run, "hard", "greedy", strange)
        survives(hopper.run, "hard", "greedy", profile=strange)
        survives(hopper.run, "hard", "greedy", dem=strange)
        survives(hopper.run, "hard", "greedy", nodata=strange)
        survives(hopper.read_journal, strange)
        survives(hopper.read_recording, strange)
        survives(hopper.check, strange)
        survives(hopper.check, lambda: strange)
        survives(hopper.World, strange, strange, strange)
        survives(hopper.solve, strange)
        survives(hopper.Action, strange)
        survives(hopper.Brief, strange), survives(hopper.State, strange), survives(hopper.Map, strange)
        survives(_native.Resolved, strange, None, None, None), survives(_native.Resolved, "hard", None, None, strange)
        survives(_native.Batch, strange, 1, 11), survives(_native.Session, strange, 1)
        for read in (_native.read_resolved, _native.read_brief, _native.read_state, _native.read_map):
            survives(read, strange), survives(read, strange, "x"), survives(lambda: repr(read([strange] * 6, [], 0)))
        for name in ("instance", "robot", "timeout"):
            # Nobody is there: what is taken ends for want of a peer.
            survives(hopper.fly, Holds(), **{"instance": f"hostile-{os.getpid()}", "wait": 0, name: strange})
        if strange is not None:
            assert not survives(hopper.fly, Holds(), instance=f"hostile-{os.getpid()}", wait=strange)
            assert not survives(hopper.fly, strange, instance=f"hostile-{os.getpid()}", wait=0)
        answer = strange

        class Answers:
            def decide(self, brief, map, state):
                return answer

        if not isinstance(answer, (int, np.integer)) or isinstance(answer, bool):
            # An array of one number is the number, to Python.
            taken = survives(hopper.run, "hard", Answers())
            assert not taken or isinstance(answer, np.ndarray), answer

        class Named(Holds):
            name = strange

        taken = survives(hopper.run, "hard", Named())
        assert not taken or isinstance(strange, str), strange
    for seed in (-1, 2**64, 2**70, 1.0, True, None, "1", math.nan, b"1", [1], np.float64(3)):
        refused("a seed needs to be", hopper.run, "hard", "greedy", seed)
    assert hopper.run("hard", "greedy", np.int64(3)).digest == hopper.run("hard", "greedy", 3).digest
    assert hopper.run("hard", "greedy", 2**64 - 1).summary["seed"] == 2**64 - 1
    for robot in ([], [16], -1, "x", 2**70, 1.5, [0, 99], None if "HOPPER_ROBOT" in os.environ else object()):
        refused("robots are numbers", hopper.fly, Holds(), robot=robot)
    for wait in (math.nan, -1, "1", math.inf, [1], True):
        refused("wait needs", hopper.fly, Holds(), wait=wait)
        refused("timeout needs", hopper.fly, Holds(), timeout=wait, wait=0)
    Named.name = 3
    refused("a planner's name needs to be text, got 3 of type int", hopper.run, "hard", Named())
    fifo, file = pathlib.Path(folder, "fifo"), pathlib.Path(folder, "file")
    os.mkfifo(fifo), file.write_text("x")
    for strange in (fifo, "/dev/null", "/dev/zero"):
        refused("a scenario needs to be a file, got a pipe or a device", hopper.run, strange)
        refused("a scenario needs to be a file, got a pipe or a device", hopper.pettingzoo.env, scenario=strange)
        refused("a regular one", hopper.run, dem=strange)
        refused("a journal needs to be a folder", hopper.read_journal, strange)
        refused("a recording needs to be a file", hopper.read_recording, strange)
    refused("a journal needs to be a folder, or the output folder of a run, got the file", hopper.read_journal, file)
    for call in (lambda: hopper.run("/proc/self/mem"), lambda: hopper.read_journal(file / "x"), lambda: hopper.read_recording(file / "x")):
        try:
            call()
        except hopper.HopperError as error:
            assert "os error" not in str(error), error
        else:
            raise AssertionError("nothing is there")
    refused("needs to be a file", hopper.read_recording, "/dev/zero")
    refused("needs to be a file", hopper.read_recording, folder)
    refused("", hopper.read_journal, folder)
    journal = pathlib.Path(folder, "journal")
    journal.mkdir()
    journal.joinpath("hops.journal").write_bytes(b"HOPPERJ\n" + bytes([5, 0, 0, 0]))
    refused("use a build of 25 November 2026 or before (format 5)", hopper.read_journal, journal)
    build = (5).to_bytes(4, "little") + b"9.9.9"
    begin = b"HOPJRNL\n" + (2).to_bytes(4, "little") + build[:4] + zlib.crc32(build).to_bytes(4, "little") + build[4:]
    journal.joinpath("hops.journal").write_bytes(begin)
    refused("it was written by version 9.9.9 (format 2)", hopper.read_journal, journal)
    for name, data in [("empty", b""), ("zeros", bytes(1000)), ("text", b"hello" * 100)]:
        path = pathlib.Path(folder, name)
        path.write_bytes(data)
        survives(hopper.read_recording, path)
        survives(hopper.run, path)
        survives(hopper.run, dem=path)
    damaged = pathlib.Path(folder, "damaged.mcap")
    damaged.write_bytes(recording_of(b"\xff\xff\xff"))
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        recording = hopper.read_recording(damaged)
    assert (recording.is_whole, recording.undecodable, recording.messages) == (True, 1, {"hop/state": 1})
    assert len(recording.states["x"]) == 0 and "1 message cannot be decoded" in str(heard[0].message), heard


def recording_of(state):
    """The bytes of an MCAP file with one message, which claims to be a state."""
    text = lambda value: struct.pack("<I", len(value)) + value.encode()
    record = lambda opcode, data: struct.pack("<BQ", opcode, len(data)) + data
    magic = b"\x89MCAP0\r\n"
    parts = [
        record(1, text("") + text("")),
        record(3, struct.pack("<H", 1) + text("hopper.State") + text("protobuf") + struct.pack("<I", 0)),
        record(4, struct.pack("<HH", 1, 1) + text("hop/state") + text("protobuf") + struct.pack("<I", 0)),
        record(5, struct.pack("<HIQQ", 1, 0, 0, 0) + state),
        record(15, struct.pack("<I", 0)),
        record(2, struct.pack("<QQI", 0, 0, 0)),
    ]
    return magic + b"".join(parts) + magic


class Looks:
    """Tries all that a planner is given."""

    def decide(self, brief, map, state):
        for strange in STRANGE:
            for action in (0, 1, strange):
                survives(brief.target, strange, action)
            survives(brief.target, state.cell, strange)
            for thing in (brief, map, state):
                for name in dir(thing):
                    if not name.startswith("__"):
                        assert not survives(setattr, thing, name, strange), name
        for cell in [(2**31 - 1, 0), (-(2**31), -(2**31)), (2**31 - 1, 2**31 - 1)]:
            for action in hopper.Action:
                assert brief.target(cell, action) is None
        for name in ("height_m", "gradient", "sand", "passable", "seen", "visits"):
            self.tampers(map, name)
        map.treasures.append((0, 0)), state.vetoed.append(7), state.robots.clear()
        assert (0, 0) not in map.treasures and 7 not in state.vetoed and state.robots
        return hopper.Action.HOLD

    shapes = {}

    def tampers(self, map, name):
        array = getattr(map, name)
        kept = array.copy()
        assert self.shapes.setdefault(name, (array.shape, array.dtype, array.strides)) == (array.shape, array.dtype, array.strides)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            while isinstance(array, np.ndarray):
                for view in (array, array[...], array.view("u1"), array.T, np.asarray(array), array.reshape(-1)):
                    assert not survives(view.setflags, write=True), name
                    assert not survives(view.__setitem__, ..., 1), name
                assert not survives(setattr, array.flags, "writeable", True)
                survives(setattr, array, "shape", (-1,))
                survives(setattr, array, "dtype", "u1")
                survives(array.sort), survives(array.resize, 1), survives(array.byteswap, True)
                assert not survives(np.frombuffer(array.base, "u1").setflags, write=True)
                array = array.base
        assert memoryview(array).readonly
        assert np.frombuffer(array, "u1").tobytes() == kept.tobytes()


def planners():
    """What a planner sees is the mission's, whatever it tries; the arrays of the next decision are as they should be."""
    flight = hopper.run("hard", Looks(), 1)
    assert flight.summary["outcome"] == "deadlock" and flight.digest == hopper.run("hard", Holds(), 1).digest


def solver():
    goal = np.zeros((5, 6), bool)
    goal[4, 5] = True
    payoff = np.where(goal, 10.0, -1.0)
    good = {"payoff": payoff, "goal": goal, "lost": np.zeros_like(goal)}
    values = hopper.solve(hopper.World(**good)).values

    def solved(error_max=1e-6, sweeps_max=1000, **fields):
        return hopper.solve(hopper.World(**{**good, **fields}), error_max=error_max, sweeps_max=sweeps_max)

    for name, strange in itertools.product(
        ["payoff", "goal", "lost", "slope_east", "slope_north", "soil", "soils", "discount", "loss", "leaving", "error_max"], STRANGE
    ):
        survives(solved, **{name: strange})
        survives(solved, **{name: [strange]})
        survives(lambda: solved(**{name: np.full((5, 6), strange, dtype=object)}))
    for text, fields in [
        ("soil needs whole numbers from 0 to 255, got 256", {"soil": np.full((5, 6), 256)}),
        ("soil needs whole numbers from 0 to 255, got -1", {"soil": -1}),
        ("soil needs whole numbers", {"soil": 0.5}),
        ("soil needs whole numbers", {"soil": math.nan}),
        ("soil needs whole numbers", {"soil": 2.0**40}),
        ("soil needs whole numbers", {"soil": 2**70}),
        ("one of 1 soils", {"soil": 1}),
        ("soil needs to be an array of real numbers", {"soil": "0"}),
        ("goal needs bools, or 0 and 1", {"goal": goal * 2}),
        ("goal needs bools, or 0 and 1", {"goal": goal * 0.5}),
        ("lost needs bools, or 0 and 1", {"lost": np.full((5, 6), np.nan)}),
        ("lost needs bools, or 0 and 1", {"lost": goal.astype("i8") * 256}),
        ("goal needs to be an array", {"goal": np.full((5, 6), "yes")}),
        ("masked", {"payoff": np.ma.masked_array(payoff, goal)}),
        ("masked", {"soil": np.ma.masked_array(np.zeros((5, 6), int), goal)}),
        ("real numbers", {"payoff": payoff + 1j}),
        ("real numbers", {"payoff": np.zeros((5, 6), "datetime64[s]")}),
        ("needs shape (5, 6)", {"goal": goal[1:]}),
        ("needs shape (5, 6)", {"slope_east": np.zeros((6, 5))}),
        ("2 dimensions", {"payoff": 1.0}),
        ("2 dimensions", {"payoff": payoff[None]}),
        ("cells", {"payoff": np.zeros((0, 5)), "goal": False, "lost": False}),
        ("cells", {"payoff": np.broadcast_to(0.0, (2**20, 2**20)), "goal": False, "lost": False}),
        ("finite payoff", {"payoff": payoff * np.nan}),
        ("finite payoff", {"payoff": payoff * np.inf}),
        ("finite payoff", {"slope_north": np.inf}),
        ("payoffs need to be so small", {"payoff": np.where(goal, 10.0, 1e308)}),
        ("payoffs need to be so small", {"payoff": np.where(goal, 10.0, -1e308)}),
        ("discount", {"discount": 1.0}), ("discount", {"discount": -0.1}), ("discount", {"discount": math.nan}),
        ("discount", {"discount": "0.9"}), ("discount", {"discount": True}), ("discount", {"discount": [0.9]}),
        ("loss", {"loss": math.inf}), ("loss", {"loss": None}), ("leaving", {"leaving": "flies"}), ("leaving", {"leaving": None}),
        ("soil", {"soils": ()}), ("soil", {"soils": ((1.0, 0.0, 0.0),)}), ("soil", {"soils": ((1.0, 0.0, 0.5, 0.0),)}),
        ("soil", {"soils": ((math.nan, 0.0, 0.0, 0.0),)}), ("soils", {"soils": None}), ("soil", {"soils": ((1.0, 0, 0, 0),) * 300}),
        ("error_max", {"error_max": -1.0}), ("error_max", {"error_max": math.nan}), ("error_max", {"error_max": math.inf}),
        ("error_max", {"error_max": None}), ("error_max", {"error_max": "1"}), ("error_max", {"error_max": 10**400}),
        ("sweeps_max", {"sweeps_max": -1}), ("sweeps_max", {"sweeps_max": 2**64}), ("sweeps_max", {"sweeps_max": 1.5}),
        ("sweeps_max", {"sweeps_max": math.nan}), ("sweeps_max", {"sweeps_max": True}),
    ]:
        refused(text, solved, **fields)
    # What means the same is the same.
    for fields in [
        {"payoff": np.asfortranarray(payoff)}, {"payoff": payoff.tolist()}, {"payoff": payoff.astype(">f8")},
        {"payoff": np.repeat(payoff, 2, axis=1)[:, ::2]}, {"payoff": payoff.astype(object)}, {"goal": goal.astype(int)},
        {"goal": goal.astype("f4")}, {"soil": np.zeros((5, 6), "i8")}, {"soil": [0] * 6}, {"discount": np.float64(0.99)},
    ]:
        assert np.array_equal(solved(sweeps_max=None, **fields).values, values), fields
    # A bound is never said to be better than it is.
    huge = np.where(goal, 100.0, 0.0)
    huge[2, 2] = 1e300
    for error_max, fields in [
        (1e-6, {"payoff": huge}), (1e-6, {"discount": 1 - 1e-15}), (1e-6, {"discount": np.nextafter(1, 0)}), (0.0, {}), (5e-324, {}),
        (1e-300, {}), (1e-6, {"payoff": payoff * 1e12}), (1e-6, {}), (1e3, {}),
    ]:
        solution = hopper.solve(hopper.World(**{**good, **fields}), error_max=error_max, sweeps_max=5000)
        assert solution.is_solved == (solution.bound <= error_max) and math.isfinite(solution.bound), (error_max, fields, solution.bound)
    assert not hopper.solve(hopper.World(**good), sweeps_max=0).is_solved


def told(env):
    unwrapped = env.unwrapped
    return [unwrapped.told(index) for index in range(env.num_envs)] if hasattr(unwrapped, "told") else unwrapped._info()


def environments():
    for strange, name in itertools.product(STRANGE, ["scenario", "profile", "window", "render_mode", "dem", "nodata"]):
        if name == "window" and isinstance(strange, int) and strange in (0, 1, 3):
            continue
        survives(hopper.gym.HopperEnv, **{name: strange})
    for strange in STRANGE:
        if not isinstance(strange, (int, np.integer)):
            survives(hopper.gym.HopperVectorEnv, strange)
        survives(hopper.pettingzoo.env, scenario=strange)
        survives(hopper.pettingzoo.env, profile=strange)
    for count in (0, -1, 2**31, 2**70, 1.5, None, "3", 2**25):
        refused("", hopper.gym.HopperVectorEnv, count)
    refused("1 to", hopper.gym.HopperVectorEnv, 2**20, scenario="vast", window=1)

    single = hopper.gym.HopperEnv()
    many = hopper.gym.HopperVectorEnv(3)
    for call in (single.step, many.step):
        for action in (2, np.array([2, 2, 2])):
            assert not survives(call, action), "a mission that is not begun"
    wrong = [None, 5, 8, -1, 2**70, 1.0, 2.5, math.nan, "1", b"1", True, np.True_, np.float64(1), np.array([1]), np.array([1, 2]), [1], object(), Liar(),
             1j, np.ma.masked, np.array(1.0)]
    single.reset(seed=1)
    many.reset(seed=1)
    single.step(1), many.step(np.array([1, 2, 3]))
    before = told(single), told(many), single.digest(), [many.digest(index) for index in range(3)]
    for action in wrong:
        refused("", single.step, action)
        for at in range(3):
            actions = [1, 2, 3]
            actions[at] = action
            refused("", many.step, actions)
    for action in range(5, 300):
        refused("0 to 4", single.step, action)
        refused("0 to 4", many.step, np.array([1, 2, action]))
    # Two of them are three whole numbers.
    for actions in [
        *[strange for strange in STRANGE if not isinstance(strange, (np.ndarray, range))], np.zeros(0), np.array([None] * 3), [1, 2], [1, 2, 3, 4], np.zeros((3, 1), int), np.zeros((1, 3), int), np.zeros(3), np.zeros(3, bool), np.array([1, 2, 3], ">f4"), 1,
        np.ma.masked_array([1, 2, 3], [0, 0, 1]), {"a": 1},
    ]:
        assert not survives(many.step, actions), actions
    for seed in [[1, 2], [1, 2, 3, 4], [1, -1, 2], [1, 2, 2**64], [1, 2.0, 3], [1, "2", 3], [True, 1, 2], (), -1, 2**64 - 2, 2**70, 1.0, "1", math.nan,
                 np.array([1.0, 2.0, 3.0]), object(), {1, 2, 3}]:
        assert not survives(many.reset, seed=seed), seed
        if not isinstance(seed, int) or seed != 2**64 - 2:
            assert not survives(single.reset, seed=seed), seed
    for index in (3, -1, 2**70, 1.0, None, True):
        refused("a mission needs", many.digest, index)
        refused("a mission needs", many.told, index)
    mine, other = single.snapshot(), hopper.gym.HopperEnv(scenario="sandy")
    other.reset(seed=1)
    for strange in [*STRANGE, many.snapshot(), other.snapshot(), mine.missions,
                    hopper.gym.Snapshot(mine.scenario, ((1, bytes([9])),), mine.random), hopper.gym.Snapshot(mine.scenario, ((-1, b""),), mine.random),
                    hopper.gym.Snapshot(mine.scenario, ((1, bytes([1] * 1000)),), mine.random), hopper.gym.Snapshot(mine.scenario, (5,), mine.random),
                    hopper.gym.Snapshot(mine.scenario, mine.missions, {})]:
        assert not survives(single.restore, strange), strange
    assert before == (told(single), told(many), single.digest(), [many.digest(index) for index in range(3)]), "nothing has moved"
    # Whole numbers of any kind are actions.
    for action in (np.int8(1), np.uint64(1), np.array(1), hopper.Action.NORTH):
        single.step(action)
    many.step(np.array([1, 2, 3], "u1")), many.step([1, 2, 3]), many.step(np.arange(6)[::2])
    while not any(single.step(1)[2:4]):
        pass
    for action in (1, None):
        assert not survives(single.step, action), "a mission that is over"
    for env in (single, many):
        env.close(), env.close()
        for call in (env.reset, lambda: env.step(1), lambda: env.step([1, 2, 3]), env.snapshot, lambda: env.digest(*([0] if env is many else []))):
            refused("", call)

    for make, step in [(hopper.pettingzoo.env, lambda env, action: env.step(action)),
                       (hopper.pettingzoo.parallel_env, lambda env, action: env.step({**dict.fromkeys(env.agents, 1), env.agents[-1]: action}))]:
        env = make()
        refused("reset()", env.snapshot)
        assert not survives(step if make is hopper.pettingzoo.env else env.step, env, 1)
        env.reset(seed=1)
        step(env, 1)
        before = env.snapshot()
        for action in wrong:
            assert not survives(step, env, action), action
        for strange in STRANGE:
            if strange is not None and not (isinstance(strange, dict) and not strange):
                assert not survives(env.reset, options=strange), strange
            if strange is not None:
                assert not survives(env.reset, seed=strange) or isinstance(strange, (int, np.integer, np.ndarray)), strange
                if not env.snapshot() == before:
                    env.restore(before)
            assert not survives(env.restore, strange)
            survives(env.observation_space, strange), survives(env.action_space, strange)
        if make is hopper.pettingzoo.parallel_env:
            for actions in [None, {}, [1, 2, 3, 4], {"robot_0": 1}, {**dict.fromkeys(env.agents, 1), "robot_9": 1}]:
                assert not survives(env.step, actions)
        assert env.snapshot() == before, "nothing has moved"
        env.close(), env.close()
        assert not survives(env.reset) and not survives(env.snapshot)


def native():
    """The native half is not promised, and does not panic either."""
    batch = _native.Batch(_native.Resolved("hard", None, None, None), 2, 11)
    rewards, ends = np.zeros(2), np.zeros(2, "u1")
    for strange in STRANGE:
        survives(batch.step, strange, rewards, ends), survives(batch.step, np.array([1, 1]), strange, ends)
        survives(batch.step, np.array([1, 1]), rewards, strange), survives(batch.observe, strange, strange)
        survives(batch.reset, strange), survives(batch.told, strange), survives(batch.digest, strange), survives(batch.scene, strange)
        survives(batch.restore, strange), survives(batch.__setstate__, strange)
    batch.reset([1, 2])
    frozen = np.zeros(2)
    frozen.setflags(write=False)
    for rewards in (frozen, np.zeros(4)[::2], np.zeros(3), np.zeros(2, "f4")):
        assert not survives(batch.step, np.array([1, 1]), rewards, ends)
    assert batch.told(0)[1] == 0
    session = _native.Session(_native.Resolved("coverage", None, None, None), 1)
    refused("call next() first", session.act, 0)
    refused("over", session.ended)
    session.next()
    refused("call act()", session.next)
    for strange in STRANGE:
        if not isinstance(strange, (int, np.integer, np.ndarray)):
            assert not survives(session.act, strange)
    for action in (1, 9, 2**31):
        refused("a hold or a step", session.act, action)
    refused("over", session.ended)


warnings.simplefilter("ignore")
for part in (functions, planners, solver, environments, native):
    part()
    print(part.__name__, calls, file=sys.stderr, flush=True)
gc.collect()
print(json.dumps({"calls": calls}))
