"""Forks in decide, in the instance of HOPPER_INSTANCE: the child returns, and gets an error; see tests/python.rs."""

import os
import sys

import hopper

sys.path.insert(0, sys.argv[1])
from planner_python import MyPlanner

children = []


class Forks(MyPlanner):
    name = "forks"

    def decide(self, brief, map, state):
        if state.decision == 3 and not children:
            children.append(os.fork())
        return super().decide(brief, map, state)


parent = os.getpid()
try:
    code = hopper.fly(Forks())
except hopper.HopperError as error:
    if os.getpid() == parent:
        raise
    print(f"child: {error}", file=sys.stderr, flush=True)
    os._exit(7)
assert os.getpid() == parent, "a child does not fly on"
_, status = os.waitpid(children[0], 0)
print(f"the child ended with {os.waitstatus_to_exitcode(status)}", file=sys.stderr, flush=True)
sys.exit(code)
