"""What an empty decide costs, from the process's question to its answer: `python decide.py HOPPER`, the program `hopper`."""

import os
import subprocess
import sys
import tempfile

import numpy as np

import hopper


class Empty:
    def decide(self, brief, map, state):
        return hopper.Action.HOLD


if "HOPPER_INSTANCE" in os.environ:
    sys.exit(hopper.fly(Empty()))

with tempfile.TemporaryDirectory() as folder:
    command = [sys.argv[1], "run", "--instance", f"decide-{os.getpid()}", "--out", f"{folder}/out", "--planner-command"]
    subprocess.run([*command, f"'{sys.executable}' '{__file__}'"], check=False, stdout=subprocess.DEVNULL)
    planning_us = hopper.read_journal(f"{folder}/out").rows["planning_ns"] / 1e3
    print("decisions", len(planning_us), *(f"p{share} {np.percentile(planning_us, share):.1f} us" for share in (50, 90, 99)))
