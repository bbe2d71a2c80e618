"""A planner that goes wrong in every way, flown in the instance of HOPPER_INSTANCE; see tests/python.rs."""

import sys
import time

import hopper

sys.path.insert(0, sys.argv[1])
from planner_python import MyPlanner


class Faulty(MyPlanner):
    name = "faulty"

    def decide(self, brief, map, state):
        match state.decision:
            case 1:
                raise ValueError("a mistake of decision 1")
            case 2:
                return "north"
            case 3:
                return None
            case 4:
                return hopper.Action.STEP_EAST
            case 5:
                while True:
                    time.sleep(0.01)
            case 6:
                self.kept = map.height_m[0]
        return super().decide(brief, map, state)


assert hopper.fly(Faulty(), timeout=3) == 0
