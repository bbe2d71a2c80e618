"""Environment steps a second in this process, one thread: PlanetaryHopper-v1 as a vector environment, and beside it gymnasium's CartPole-v1 and, where
it is installed (`pip install jumanji`), Jumanji's Maze-v0, an agent on a grid as well."""

import os
import time
import warnings

import gymnasium
import numpy as np

import hopper.gym  # noqa: F401, registers the environment

ENVIRONMENTS, STEPS = 1024, 500

warnings.simplefilter("ignore")


def rate(step, chosen):
    """The median of five rounds, in steps a second."""
    rates = []
    for _ in range(5):
        since = time.perf_counter()
        for each in chosen:
            step(each)
        rates.append(ENVIRONMENTS * STEPS / (time.perf_counter() - since))
    return np.median(rates)


def maze():
    """A step of Jumanji's mazes of 10 x 10 cells, compiled by JAX for one thread, with a new maze at the end of each; or nothing."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    try:
        import jax
        import jumanji
        from jumanji.wrappers import VmapAutoResetWrapper
    except ImportError:
        return None
    env = VmapAutoResetWrapper(jumanji.make("Maze-v0"))
    state = jax.jit(env.reset)(jax.random.split(jax.random.PRNGKey(1), ENVIRONMENTS))[0]
    compiled = jax.jit(env.step)

    def step(actions):
        nonlocal state
        state, seen = compiled(state, actions)
        seen.observation.agent_position.row.block_until_ready()

    step(np.zeros(ENVIRONMENTS, np.int32))
    return step


for name, actions, arguments in [
    ("PlanetaryHopper-v1", 5, {"scenario": "hard", "window": 11}),
    ("PlanetaryHopper-v1", 5, {"scenario": "hard", "window": 11, "copy": False}),
    ("CartPole-v1", 2, {}),
]:
    env = gymnasium.make_vec(name, num_envs=ENVIRONMENTS, vectorization_mode="vector_entry_point", **arguments)
    env.reset(seed=1)
    chosen = np.random.default_rng(1).integers(actions, size=(STEPS, ENVIRONMENTS))
    print(f"{name:12} {arguments}: {rate(env.step, chosen) / 1e6:.2f} million steps a second")

if step := maze():
    chosen = np.random.default_rng(1).integers(4, size=(STEPS, ENVIRONMENTS), dtype=np.int32)
    print(f"Maze-v0 of Jumanji: {rate(step, chosen) / 1e6:.2f} million steps a second")
