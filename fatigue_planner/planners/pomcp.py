"""Monte-Carlo tree search from the belief: POMCP, POMCP-Max (paper, section III-D) and their variants."""

import time

import numpy as np

from fatigue_planner.planners.parts import BACKUPS, EXPLORATIONS, search_kernel
from fatigue_planner.planners.policy import Decision, Policy, explained
from fatigue_planner.planners.search.descent import Numbers, tables
from fatigue_planner.planners.search.tree import UNVISITED, Tree, copy_subtree, new_tree
from fatigue_planner.planners.settings import PomcpSettings
from fatigue_planner.pomdp.beliefs.belief import Belief

# A search with a time limit looks at the clock once per so many descents.
DESCENTS_PER_LOOK = 50
FIRST_CAPACITY = 4096


class PomcpPolicy(Policy):
    """A tree search; its settings say what it is made of and when it ends."""

    def __init__(self, settings: PomcpSettings) -> None:
        self.settings = settings
        self.draws_at_random = settings.seconds is not None  # how far it comes in a time differs from run to run
        self._searched: Tree | None = None
        self._kept: Tree | None = None
        self._depth = 0
        self._tables = tables(0)

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action with the best estimated return at the root; the first of equals."""
        begin = time.perf_counter()
        tree = self.tree(belief, rng, begin)
        tried = tree.tried[0] > 0
        values = np.where(tried, tree.value[0], np.nan)
        action = int(np.where(tried, tree.value[0], -np.inf).argmax())
        descents = int(tree.visited[0]) - 1
        reason = explained(f"best estimated return after {descents} descents", belief)
        visits = tree.tried[0].astype(np.int64)
        return Decision(action, values, visits, self._depth, time.perf_counter() - begin, reason)

    def observe(self, action: int, observation: int) -> None:
        """With reuse, what follows of the tree becomes the next one."""
        tree, self._searched, self._kept = self._searched, None, None
        if self.settings.reuse_tree and tree is not None:
            node = int(tree.child[0, action, observation])
            if node != UNVISITED:
                self._kept = _empty_tree_like(tree, int(tree.visited[node]))
                copy_subtree(tree, node, self._kept)

    def tree(self, belief: Belief, rng: np.random.Generator, begin: float) -> Tree:
        """The search tree grown from a belief; `begin` is when the decision began (perf_counter)."""
        settings, model = self.settings, belief.model
        kernel = search_kernel(model, settings.backup, settings.exploration, settings.leaf_value)
        tree, self._kept = self._kept, None
        used = 0 if tree is None else int(tree.used[0])
        capacity = used + (settings.descents or FIRST_CAPACITY) + 1
        if tree is None:
            backup, exploration = BACKUPS[settings.backup], EXPLORATIONS[settings.exploration]
            sizes = capacity, len(model.actions), len(model.observations)
            tree = new_tree(*sizes, backup.with_chances, exploration.with_spread)
        else:
            tree = _grown(tree, capacity)
        self._depth = 0
        if settings.descents is not None:
            self._grow(kernel, belief, tree, settings.descents, rng)
        else:
            assert settings.seconds is not None
            tree = self._grow_until(kernel, belief, tree, begin + settings.seconds, rng)
        self._searched = tree
        return tree

    def _grow(self, kernel: object, belief: Belief, tree: Tree, descents: int, rng: np.random.Generator) -> None:
        capacity = tree.visited.size
        if self._tables[0].size <= capacity:
            self._tables = tables(2 * capacity)
        settings, model = self.settings, belief.model
        numbers = Numbers(
            settings.exploration_constant,
            model.discount,
            settings.rollout_cycles,
            len(model.outcomes),
            *self._tables,
        )
        assert callable(kernel)
        depth = kernel(model.arrays, belief.states, belief.weights, tree, descents, numbers, rng)
        self._depth = max(self._depth, depth)

    def _grow_until(self, kernel: object, belief: Belief, tree: Tree, end: float, rng: np.random.Generator) -> Tree:
        """Grow until another look at the clock might come too late; one descent at least per action."""
        descents, longest = len(belief.model.actions), 0.0
        while True:
            if int(tree.used[0]) + descents > tree.visited.size:
                tree = _grown(tree, 2 * tree.visited.size)
            begin = time.perf_counter()
            self._grow(kernel, belief, tree, descents, rng)
            now = time.perf_counter()
            longest = max(longest, (now - begin) / descents * DESCENTS_PER_LOOK)
            descents = DESCENTS_PER_LOOK
            if now + 2 * longest > end:
                return tree


def _empty_tree_like(tree: Tree, capacity: int) -> Tree:
    _, actions, observations = tree.child.shape
    return Tree(*new_tree(capacity, actions, observations, tree.chance.shape[0] > 0, tree.spread.size > 0))


def _grown(tree: Tree, capacity: int) -> Tree:
    """The same tree with more room."""
    larger = _empty_tree_like(tree, capacity)
    copy_subtree(tree, 0, larger)
    return larger
