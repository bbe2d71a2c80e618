#!/usr/bin/env python3
"""Plans with a bound on the risk beside a linear program over occupation measures, solved by HiGHS.

The program has a variable for each hop at each node: how often it is taken. It minimises expected steps plus the charge for a loss, subject to the
flow of the process and to P(loss) at most the bound, so its optimum is that of all policies, randomised and with memory. It has to lie between Hopper's
lower bound and what Hopper's plan achieves, each widened by 1e-6 of the cost.

    bench/.venv/bin/python bench/risk.py [--sizes 20,50] [--seeds 1,2,3]
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, vstack

HERE = Path(__file__).resolve().parent
# How far an optimum may lie outside Hopper's bounds, as a share of the cost.
WIDENED = 1e-6


def load(folder):
    """Landings, probabilities and steps of each row, rows and number of the live nodes, and the start."""
    to = np.fromfile(folder / "to.i32", "<i4").reshape(-1, 4)
    probabilities = np.fromfile(folder / "probabilities.f64", "<f8").reshape(-1, 4)
    steps = np.fromfile(folder / "steps.f64", "<f8")
    free = np.fromfile(folder / "free.u8", "u1").astype(bool)
    start = json.loads((folder / "start.json").read_text())["start"]
    return to, probabilities, steps, free, start


def states(to, probabilities, free, start):
    """Free nodes that the start leads to and that lead to the goal; whatever leads nowhere counts as lost."""
    taken = np.repeat(free, 4)
    leads = np.zeros(len(free), bool)
    while True:
        arrives = (probabilities > 0) & ((to == -1) | ((to >= 0) & leads[np.maximum(to, 0)]))
        now = free & arrives.any(axis=1).reshape(-1, 4).any(axis=1)
        if (now == leads).all():
            break
        leads = now
    met = np.zeros(len(free), bool)
    met[start] = True
    while True:
        rows = np.repeat(met & leads, 4) & taken
        ends = to[rows][(probabilities[rows] > 0) & (to[rows] >= 0)]
        now = met.copy()
        now[ends] = True
        if (now == met).all():
            break
        met = now
    return np.flatnonzero(met & leads)


class Program:
    def __init__(self, folder):
        to, probabilities, steps, free, start = load(folder)
        nodes = states(to, probabilities, free, start)
        number = np.full(len(free), -1)
        number[nodes] = np.arange(len(nodes))
        rows = (4 * nodes[:, None] + np.arange(4)).ravel()
        ends, shares = to[rows], probabilities[rows]
        inside = (ends >= 0) & (number[np.maximum(ends, 0)] >= 0)
        self.lost = np.where(inside | (ends == -1), 0.0, shares).sum(axis=1)
        self.steps = steps[rows]
        self.shares, self.ends = np.where(inside, shares, 0.0), np.where(inside, number[np.maximum(ends, 0)], 0)
        count = len(nodes)
        columns = np.arange(4 * count)
        leaves = coo_matrix((np.ones(4 * count), (columns // 4, columns)), (count, 4 * count))
        arrives = coo_matrix(
            (self.shares.ravel(), (self.ends.ravel(), np.repeat(columns, 4))), (count, 4 * count)
        )
        self.flow = (leaves - arrives).tocsr()
        self.enters = np.zeros(count)
        self.enters[number[start]] = 1.0
        self.start = number[start]

    def optimum(self, bound, charge):
        begun = time.perf_counter()
        solved = linprog(
            self.steps + charge * self.lost,
            A_ub=coo_matrix(self.lost[None, :]),
            b_ub=[bound],
            A_eq=self.flow,
            b_eq=self.enters,
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if not solved.success:
            raise SystemExit(f"HiGHS: {solved.message}")
        return solved.fun, time.perf_counter() - begun


def main():
    numbers = lambda text: [int(word) for word in text.split(",")]
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sizes", type=numbers, default=[20, 50], help="nodes a side, comma-separated")
    parser.add_argument("--seeds", type=numbers, default=[1, 2, 3], help="seeds of worlds, comma-separated")
    parser.add_argument("--bench", help="Hopper's side, built; by default it is built for release")
    chosen = parser.parse_args()
    if chosen.bench is None:
        subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "bench"], cwd=HERE, check=True)
    command = chosen.bench or HERE.parent / "target" / "release" / "bench"
    print("| side | seed | bound | dual | optimum (HiGHS) | achieved | gap | λ | solves | Hopper, s | × of λ = 0 | HiGHS, s |")
    print("| --- " * 12 + "|")
    outside = 0
    for side in chosen.sizes:
        for seed in chosen.seeds:
            with tempfile.TemporaryDirectory() as folder:
                words = [command, "risk", str(side), folder, "--seed", str(seed)]
                plans = json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE).stdout)
                program = Program(Path(folder))
            for plan in plans["answers"]:
                optimum, seconds = program.optimum(plan["bound"], plans["charge"])
                slack = WIDENED * optimum
                is_inside = plan["feasible"] and plan["dual"] - slack <= optimum <= plan["cost"] + slack
                outside += not is_inside
                row = (
                    f"| {side} | {seed} | {plan['bound']:.6f} | {plan['dual']:.6f} | {optimum:.6f}{'' if is_inside else ' **outside**'} "
                    f"| {plan['cost']:.6f} | {(plan['cost'] - plan['dual']) / plan['cost']:.1e} | {plan['multiplier']:.5g} "
                    f"| {plan['solves']} | {plan['seconds']:.4f} | {plan['seconds'] / plans['free_seconds']:.1f} | {seconds:.2f} |"
                )
                print(row, flush=True)
    if outside:
        raise SystemExit(f"{outside} optima lie outside Hopper's bounds")


if __name__ == "__main__":
    main()
