"""What robots can be commanded to do."""

import enum


class Action(enum.IntEnum):
    """What a planner may command: hold or a hop; of a rover, hold or a step. Values are the codes on the wire."""

    HOLD = 0
    NORTH = 1
    EAST = 2
    SOUTH = 3
    WEST = 4
    STEP_NORTH = 5
    STEP_EAST = 6
    STEP_SOUTH = 7
    STEP_WEST = 8


#: The hops of a hopper, in the order in which ties are broken.
HOPS = (Action.NORTH, Action.EAST, Action.SOUTH, Action.WEST)

#: The steps of a rover, in the order in which ties are broken.
STEPS = (Action.STEP_NORTH, Action.STEP_EAST, Action.STEP_SOUTH, Action.STEP_WEST)
