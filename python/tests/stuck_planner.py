"""Holds, and does not return from decide at the decision that is given."""

import sys

import hopper


class Stuck:
    def decide(self, brief, map, state):
        if state.decision == int(sys.argv[1]):
            print(f"stuck at decision {state.decision}", file=sys.stderr, flush=True)
            while True:
                pass
        return hopper.Action.HOLD


sys.exit(hopper.fly(Stuck(), timeout=3600))
