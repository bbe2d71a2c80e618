"""What robots can be commanded to do."""

import enum


class Action(enum.IntEnum):
    """What a planner may command: hold or a hop; of a rover, hold or a step. Values are the codes on the wire.

    The vertical hops UP_NORTH to UP_WEST are for scenarios that have them (`robot.vertical`).
    """

    HOLD = 0
    NORTH = 1
    EAST = 2
    SOUTH = 3
    WEST = 4
    STEP_NORTH = 5
    STEP_EAST = 6
    STEP_SOUTH = 7
    STEP_WEST = 8
    UP_NORTH = 14
    UP_EAST = 15
    UP_SOUTH = 16
    UP_WEST = 17


#: The hops of a hopper, in the order in which ties are broken.
HOPS = (Action.NORTH, Action.EAST, Action.SOUTH, Action.WEST)

#: The vertical hops of a hopper, in the same order: where a hop would collide, in scenarios that have them.
UPS = (Action.UP_NORTH, Action.UP_EAST, Action.UP_SOUTH, Action.UP_WEST)

#: The steps of a rover, in the order in which ties are broken.
STEPS = (Action.STEP_NORTH, Action.STEP_EAST, Action.STEP_SOUTH, Action.STEP_WEST)
