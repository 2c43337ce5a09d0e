"""One search from its first tree to its last improvement, in steps of a few iterations.

A tree finds a way, replacements polish it, a new tree looks for another one that may become shorter; and so on.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.growth import Growth, grow
from trackctl.planning.pieces import Task, new_way
from trackctl.planning.polish import CAPACITY as PIECE_CAPACITY
from trackctl.planning.polish import Path, measure, new_path, polish
from trackctl.planning.random_numbers import stream_of
from trackctl.planning.route import Route
from trackctl.planning.target import End, Target, copy_end, is_exact, new_end
from trackctl.planning.tree import new_tree

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: Nodes of a tree at most.
NODE_CAPACITY = 50_000
#: Longest extension, in smallest radii.
REACH = 3.5
#: How far ahead on the guide points are drawn, in longest extensions.
AHEAD = 2.0
#: Iterations of a step.
BATCH = 64
#: Iterations that a new way is polished for before it is compared, and what it may then lack to go on.
TRIAL, TRIAL_LACK = 256, 1.03
#: Iterations after which a way is done with unless it keeps getting shorter, and the gain that counts as that.
PATIENCE, GAIN = 512, 1e-4
#: Share of the best cost that a tree's rough way may have: polishing takes off about as much.
ROUGHNESS = 1.25
#: Iterations of the first tree before it is given up for a new one; each that finds nothing doubles them.
FIRST_PATIENCE = 4000


class Anytime:
    """State of a search; a function of task, poses, seed and the number of iterations done.

    Attributes
    ----------
    iterations, nodes
        Done so far.
    cost
        Of the best route, infinite without one.
    slack
        No end within the tolerance is farther from the surest one. [m]
    """

    def __init__(self, task: Task, start: Pose, target: Target, surest: End, seed: int) -> None:
        self._task, self._start, self._target = task, start, target
        self.slack = 0.0 if is_exact(target) else 2.0 * (target.distance + abs(target.lead))
        self._tree = new_tree(NODE_CAPACITY, start)
        self._tree.gear[0] = task.first_gear
        self._growth = Growth(
            stream=stream_of(seed),
            target=target,
            surest=surest,
            slack=self.slack,
            reach=REACH * float(task.radii[0]),
            way=new_way(),
            shot=new_way(),
            best=np.array([np.inf]),
            bound=np.array([np.inf]),
            guide=np.empty((0, 2)),
            frontier=np.zeros(2, np.int64),
            last=np.array([-1, 0]),
            solution=new_way(),
            aimed=End(surest.route.copy(), surest.body.copy()),
            end=new_end(),
        )
        self._best, self._trial = new_path(), new_path()
        self._polishing: Path | None = None
        self._polished, self._cost_before = 0, math.inf
        self._grown, self._patience = 0, FIRST_PATIENCE
        self._finished_nodes = 0
        self.iterations = 0
        self.cost = math.inf

    @property
    def nodes(self) -> int:
        """Of all trees."""
        return self._finished_nodes + int(self._tree.size[0])

    def step(self, most: int) -> bool:
        """Go on for some iterations; whether that found a better route."""
        count = min(BATCH, most)
        before = self.cost
        if self._polishing is None:
            self._grow(count)
        else:
            self._polish(self._polishing, count)
        return self.cost < before

    def follow(self, guide: Array) -> None:
        """Grow trees by some points from now on."""
        spacing = np.hypot(*np.diff(guide, axis=0).T).mean() if len(guide) > 1 else math.inf
        self._growth = self._growth._replace(guide=guide)
        self._growth.frontier[:] = len(guide) - 1, AHEAD * self._growth.reach / spacing + 1.0

    def route(self) -> Route:
        """The best route so far."""
        count = int(self._best.piece_count[0])
        return Route(self._start, *(part[:count].copy() for part in self._best.pieces))

    def goal(self) -> Pose:
        """Where the body is to be at the end of the best route's plan: x, y [m] and yaw. [rad]"""
        x, y, yaw = self._best.end.body.tolist()
        return x, y, yaw

    def _grow(self, count: int) -> None:
        done, found = grow(self._task, self._tree, self._growth, count)
        self.iterations += done
        self._grown += done
        if found:
            self._polishing = self._trial
            self._load_trial()
            self._polished, self._cost_before = 0, math.inf
            self._take_if_better()
            self._new_tree()
        elif self._grown >= self._patience or int(self._tree.size[0]) == NODE_CAPACITY:
            self._patience *= 2
            self._new_tree()

    def _new_tree(self) -> None:
        self._finished_nodes += int(self._tree.size[0])
        self._tree.size[0] = 1
        self._grown = 0
        self._growth.frontier[0] = len(self._growth.guide) - 1
        self._growth.best[0] = np.inf
        self._growth.bound[0] = ROUGHNESS * self.cost

    def _polish(self, path: Path, count: int) -> None:
        cost = polish(self._task, path, self._growth.stream, self._target, count)
        self.iterations += count
        self._polished += count
        self._take_if_better()
        hopeless = path is self._trial and self._polished >= TRIAL and cost > TRIAL_LACK * self.cost
        if self._polished % PATIENCE < BATCH and self._polished >= PATIENCE:
            hopeless |= cost > (1.0 - GAIN) * self._cost_before
            self._cost_before = cost
        if hopeless:
            self._polishing = None
            self._growth.bound[0] = ROUGHNESS * self.cost

    def _take_if_better(self) -> None:
        """Let the best path and that on trial change places once it is better, and note the cost of the best."""
        if self._polishing is self._trial and self._cost_of(self._trial) < self.cost:
            self._best, self._trial = self._trial, self._best
            self._polishing = self._best
        if self._polishing is self._best:
            self.cost = self._cost_of(self._best)

    def _cost_of(self, path: Path) -> float:
        return float(path.cost[path.piece_count[0]])

    def _load_trial(self) -> None:
        """Copy the pieces from the start along the tree and on to the goal, empty ones left out."""
        tree, growth, trial = self._tree, self._growth, self._trial
        rows = [[part[: growth.last[1]] for part in growth.solution]]
        node = int(growth.last[0])
        while node > 0:
            rows.append([part[node, : tree.piece_count[node]] for part in tree.pieces])
            node = int(tree.parent[node])
        curvature, length, pivot = (np.concatenate(parts) for parts in zip(*reversed(rows), strict=True))
        used = np.flatnonzero((length != 0.0) | (pivot != 0.0))[:PIECE_CAPACITY]
        for place, values in zip(trial.pieces, (curvature, length, pivot), strict=True):
            place[: used.size] = values[used]
        trial.piece_count[0] = used.size
        copy_end(growth.end, trial.end)
        measure(self._task, trial, self._start)
