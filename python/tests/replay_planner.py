"""Commands the actions that it is given, in the instance of HOPPER_INSTANCE."""

import json
import sys

import hopper


class Replay:
    name = "replay"
    actions = json.loads(sys.argv[1])

    def decide(self, brief, map, state):
        return self.actions[state.decision]


assert hopper.fly(Replay()) == 0
