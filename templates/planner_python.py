"""Hops towards the goal, around what is known to be impassable."""
import hopper


class MyPlanner:
    def decide(self, brief, map, state):
        def distance(action):
            x, y = brief.target(state.cell, action)
            return (x - brief.goal[0]) ** 2 + (y - brief.goal[1]) ** 2

        def is_open(action):
            cell = brief.target(state.cell, action)
            known = cell and map.seen[cell[::-1]]  # arrays are indexed [y, x]
            return cell and action not in state.vetoed and (not known or map.passable[cell[::-1]])

        return min(filter(is_open, hopper.HOPS), key=distance, default=hopper.Action.HOLD)


if __name__ == "__main__":
    hopper.fly(MyPlanner())
