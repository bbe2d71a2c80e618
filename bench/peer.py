"""Solves one exported world with one peer, or checks the values that all have left beside it.

    peer.py NAME FOLDER     solve, leave FOLDER/NAME.f64, print times and memory as JSON
    peer.py check FOLDER    compare every FOLDER/*.f64 with Hopper's and with Bellman's equation

Runs in the virtual environment that `bench/run` makes. The folder's format stands in src/rows.rs:
states with four rows each, V(s) = max over rows of reward + sum of weight * V(to). A peer that knows
no weights below 1 gets one more state in which the process ends: it pays nothing and is never left.
"""

import json
import resource
import sys
import time
from pathlib import Path

import numpy as np
import scipy.sparse as sparse

# As in src/stopwatch.rs.
LONG_ENOUGH_S = 0.5
SOLVES_MAX = 101


class World:
    """The rows of an exported world."""

    def __init__(self, folder):
        header = json.loads((folder / "world.json").read_text())
        self.states = header["states"]
        self.discount = header["discount"]
        self.error_max = header["error_max"]
        self.rewards = np.fromfile(folder / "rewards.f64", "<f8")
        to = np.fromfile(folder / "to.i32", "<i4")
        weights = np.fromfile(folder / "weights.f64", "<f8")
        leads = to >= 0
        starts = np.concatenate(([0], np.cumsum(leads.reshape(-1, header["landings"]).sum(axis=1))))
        shape = (4 * self.states, self.states)
        self.weights = sparse.csr_matrix((weights[leads], to[leads], starts), shape=shape)
        self.weights.sum_duplicates()
        self.weights.sort_indices()
        self.weights.eliminate_zeros()

    def ends(self, scale=1.0):
        """What the weights of each row, divided by `scale`, leave to the state in which all ends."""
        ends = 1.0 - np.asarray(self.weights.sum(axis=1)).ravel() / scale
        ends[ends < 1e-12] = 0.0  # rounding
        return ends

    def discounted(self):
        """Transition probabilities, a row per row and one for the end, of a process with one discount.

        A hop that takes two periods has weights discounted twice; what is missing to one discount
        goes to the end.
        """
        inner = sparse.hstack([self.weights / self.discount, sparse.csr_matrix(self.ends(self.discount)[:, None])])
        end = sparse.csr_matrix(([1.0], ([0], [self.states])), shape=(1, self.states + 1))
        return sparse.vstack([inner, end]).tocsr()

    def residual(self, values):
        """max |V - TV|, in numpy, from the exported numbers."""
        return float(np.abs((self.rewards + self.weights @ values).reshape(-1, 4).max(axis=1) - values).max())


def storm(world):
    """Optimistic value iteration over the expected reward until the end is reached.

    Discounting is ending: each row goes to the end with what its weights leave. Storm's iteration
    starts at 0 and needs rewards of 0 or more, so the potential k is added to every state's value:
    a row's reward becomes reward + k * (its probability to end), the values become V + k whatever the
    policy, and k is taken off again afterwards. k is the least that makes all rewards 0 or more.
    """
    import stormpy
    from stormpy import datastructures, environments, models

    ends = world.ends()
    shift = max(0.0, float((-world.rewards / ends).max()))
    rewards = np.maximum(world.rewards + shift * ends, 0.0)  # rounding

    states, end = world.states, world.states
    builder = datastructures.SparseMatrixBuilder[float](4 * states + 1, states + 1, 0, True, True, states + 1)
    entry, group = builder.add_next_value, builder.new_row_group
    starts, columns, weights = world.weights.indptr, world.weights.indices, world.weights.data
    for row in range(4 * states):
        if row % 4 == 0:
            group(row)
        for slot in range(starts[row], starts[row + 1]):
            entry(row, columns[slot], weights[slot])
        entry(row, end, ends[row])
    group(4 * states)
    entry(4 * states, end, 1.0)
    labels = models.StateLabeling(states + 1)
    for label, state in (("init", 0), ("end", end)):
        labels.add_label(label)
        labels.add_label_to_state(label, state)
    rewards = models.SparseRewardModel[float](optional_state_action_reward_vector=[*rewards.tolist(), 0.0])
    parts = models.SparseModelComponents[float](
        transition_matrix=builder.build(), state_labeling=labels, reward_models={"payoff": rewards}
    )
    mdp = models.SparseMdp[float](parts)
    del builder, parts, rewards

    environment = environments.Environment()
    solver = environment.solver()
    solver.force_soundness = True
    settings = solver.min_max()
    settings.method = environments.MinMaxMethod.OPTIMISTIC_VALUE_ITERATION
    settings.precision = stormpy.Rational(world.error_max)
    settings.relative_termination_criterion = False
    question = stormpy.parse_property('R{"payoff"}max=? [F "end"]')

    def solve():
        return stormpy.model_checking(mdp, question, environment=environment)

    def values(result):
        return np.fromiter((result.get_value(state) for state in range(states)), float, states) - shift

    return solve, values


def quantecon(world):
    """Modified policy iteration, 20 partial evaluations a round; an epsilon of 2e gives values within e."""
    from quantecon.markov import DiscreteDP

    states = world.states
    state_of_row = np.append(np.repeat(np.arange(states), 4), states)
    hop_of_row = np.append(np.tile(np.arange(4), states), 0)
    rewards = np.append(world.rewards, 0.0)
    process = DiscreteDP(rewards, world.discounted(), world.discount, state_of_row, hop_of_row)

    def solve():
        return process.solve("modified_policy_iteration", epsilon=2 * world.error_max, max_iter=1_000_000, k=20)

    return solve, lambda result: result.v[:states]


def mdpsolver(world):
    """Modified policy iteration with Gauss-Seidel updates, one thread, the final check left out.

    Its standard updates stop at values that are wrong by a constant. A model keeps its last solution
    as the next start, so every solve has a model of its own, made before the clock starts.
    """
    import mdpsolver as peer

    process = world.discounted()
    starts, columns, weights = process.indptr, process.indices.tolist(), process.data.tolist()
    rows = [slice(starts[row], starts[row + 1]) for row in range(process.shape[0])]
    groups = [rows[row : row + 4] for row in range(0, len(rows) - 1, 4)] + [rows[-1:]]
    to = [[columns[row] for row in group] for group in groups]
    weights = [[weights[row] for row in group] for group in groups]
    rewards = [*world.rewards.reshape(-1, 4).tolist(), [0.0]]
    del process, columns, rows, groups

    def prepare():
        model = peer.model()
        model.mdp(discount=world.discount, rewards=rewards, tranMatProbs=weights, tranMatColumns=to)
        return model

    def solve(model):
        model.solve(
            algorithm="mpi",
            update="gs",
            parIterLim=20,
            tolerance=world.error_max,
            parallel=False,
            postProcessing=False,
            makeFinalCheck=False,
        )
        return model

    return solve, lambda model: np.array(model.getValueVector()[: world.states]), prepare


def pymdptoolbox(world):
    """Value iteration on sparse matrices."""
    from mdptoolbox import mdp

    process = world.discounted()
    transitions = [sparse.vstack([process[hop:-1:4], process[-1]]).tocsr() for hop in range(4)]
    rewards = np.vstack([world.rewards.reshape(-1, 4), np.zeros(4)])

    def prepare():
        return mdp.ValueIteration(transitions, rewards, world.discount, epsilon=world.error_max, max_iter=1_000_000)

    def solve(iteration):
        iteration.run()
        return iteration

    return solve, lambda iteration: np.array(iteration.V)[: world.states], prepare


PEERS = {peer.__name__: peer for peer in (storm, quantecon, mdpsolver, pymdptoolbox)}


def repeat(solve, prepare=None):
    """Times of `solve`: once unmeasured if it is quick, then for half a second or 101 times."""

    def measure():
        ready = [prepare()] if prepare else []
        wall, processor = time.perf_counter(), time.process_time()
        result = solve(*ready)
        return time.perf_counter() - wall, time.process_time() - processor, result

    wall_s, processor_s, result = measure()
    walls, processors = [wall_s], [processor_s]
    if wall_s < LONG_ENOUGH_S:
        walls, processors, begin = [], [], time.perf_counter()
        while not walls or (time.perf_counter() - begin < LONG_ENOUGH_S and len(walls) < SOLVES_MAX):
            wall_s, processor_s, result = measure()
            walls.append(wall_s)
            processors.append(processor_s)
    return {"wall_s": walls, "processor_s": processors}, result


def peak_bytes():
    """Largest resident size of this process so far."""
    try:
        status = Path("/proc/self/status").read_text()
        return next(int(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmHWM:"))
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def run(name, folder):
    world = World(folder)
    solve, values, *prepare = PEERS[name](world)
    peak_before = peak_bytes()
    times, result = repeat(solve, *prepare)
    peak = peak_bytes()
    values(result).astype("<f8").tofile(folder / f"{name}.f64")
    return {"times": times, "peak_bytes": peak, "peak_before_solve_bytes": peak_before}


def check(folder):
    """How far every solver's values are from Hopper's, and from solving Bellman's equation."""
    world = World(folder)
    hopper = np.fromfile(folder / "hopper.f64", "<f8")
    answer = {}
    for path in sorted(folder.glob("*.f64")):
        if path.stem in ("rewards", "weights"):
            continue
        values = np.fromfile(path, "<f8")
        answer[path.stem] = {
            "difference": float(np.abs(values - hopper).max()),
            "residual": world.residual(values),
        }
    return answer


if __name__ == "__main__":
    name, folder = sys.argv[1], Path(sys.argv[2])
    print(json.dumps(check(folder) if name == "check" else run(name, folder)))
