"""Monte-Carlo tree search from the belief: POMCP, POMCP-Max (paper, section III-D) and their variants."""

import time
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.pcg64 import go_on, words_of
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, explained
from fatigue_planner.planners.pomcp.buffers import TINY, SearchParameters, Workspace, new_workspace, tables
from fatigue_planner.planners.pomcp.kernels import (
    BACKUPS,
    EXPLORATIONS,
    LEAF_VALUE,
    ROLLOUT_CYCLES,
    BackupName,
    ExplorationName,
    LeafValueName,
    bound_arrays_for,
    keeps_rewards,
    search_kernel,
)
from fatigue_planner.planners.pomcp.sparse.policy import Search, SparsePolicy, needs_a_sparse_tree
from fatigue_planner.planners.pomcp.tree import UNVISITED, Tree, clear, graft, new_tree, node_type
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.problem import Pomdp

# How many descents a search with a time limit makes between two looks at the clock.
DESCENTS_PER_LOOK = 50
# The largest tree of a search with a time limit; the system provides its memory only where it is used.
MAX_NODES = 1_000_000
MAX_BYTES = 2**28


class PomcpPolicy(Policy):
    """A tree search; its settings choose its parts and when it ends.

    Its memory is kept from decision to decision, so a tree lasts until the next one is grown.
    """

    def __init__(self, settings: "PomcpSettings") -> None:
        self.settings = settings
        # how many descents fit in a time differs from run to run, and random rollouts are drawn for every worker
        self.draws_at_random = settings.seconds is not None or settings.leaf_value == "random_rollout"
        self._tree: Tree | None = None
        self._spare: Tree | None = None
        self._kept = False  # whether `observe` kept the tree for this decision
        self._workspace: Workspace | None = None
        self._tables = tables(0 if settings.seconds is None else MAX_NODES + 1)
        self._model: Pomdp | None = None
        self._kernel: Any = None
        self._depth = 0
        self._sparse: SparsePolicy | None = None

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action with the best estimated return at the root; ties go to the first."""
        begin = time.perf_counter()
        if needs_a_sparse_tree(belief.model):
            return self._sparse_search().act(belief, rng)
        root = self.tree(belief, rng, begin).nodes[0]
        visits, values = root["tried"].astype(np.int64), root["value"].copy()
        if visits.all():
            action = int(values.argmax())
        else:
            values[visits == 0] = np.nan
            action = int(np.nanargmax(values))
        reason = explained(f"best estimated return after {root['visited'] - 1} descents", belief)
        return Decision(action, values, visits, self._depth, time.perf_counter() - begin, reason)

    def _sparse_search(self) -> SparsePolicy:
        """The search for problems that this one does not know. Raises ProblemError if a tree is to be reused."""
        settings = self.settings
        if settings.reuse_tree:
            raise ProblemError(
                "reuse_tree: a tree is not reused in a problem with many observations, or with more than three "
                "functions of its own; leave it out."
            )
        if self._sparse is None:
            search = settings.backup, settings.exploration, settings.exploration_constant
            leaf = settings.leaf_value, settings.rollout_cycles
            self._sparse = SparsePolicy(Search(*search, *leaf, settings.descents, settings.seconds))
        return self._sparse

    def observe(self, action: int, observation: int) -> None:
        """If the tree is reused, keep its part below this action and observation for the next decision."""
        tree = self._tree
        if tree is None or not self.settings.reuse_tree:
            return
        node = int(tree.nodes["child"][0, action, observation])
        if node == UNVISITED:
            return
        if self._spare is None or self._spare.nodes.size < tree.nodes.size:
            self._spare = new_tree(tree.nodes.size, tree.nodes.dtype)
        clear(self._spare)
        graft(tree, node, self._spare)
        self._tree, self._spare, self._kept = self._spare, tree, True

    def tree(self, belief: Belief, rng: np.random.Generator, begin: float) -> Tree:
        """The search tree grown from a belief; `begin` is when the decision began (perf_counter)."""
        settings, model = self.settings, belief.model
        if model is not self._model:
            if self._model is None or not _same_task(model, self._model):
                model.check_probabilities(belief.states)
                self._tree = self._spare = self._workspace = None
            self._model = model
            self._kernel = search_kernel(model, settings.backup, settings.exploration, settings.leaf_value)
        else:
            model.check_again(belief.states)
        if self._tree is not None and not self._kept:
            clear(self._tree)
        self._kept = False
        self._depth = 0
        if settings.descents is not None:
            return self._grow(belief, settings.descents, rng)
        assert settings.seconds is not None
        return self._grow_until(belief, begin + settings.seconds, rng)

    def _grow(self, belief: Belief, descents: int, rng: np.random.Generator) -> Tree:
        settings, model = self.settings, belief.model
        tree, workspace = self._memory(belief, descents)
        constant = max(settings.exploration_constant, TINY)
        bound_arrays = bound_arrays_for(model, settings.leaf_value)
        parameters = SearchParameters(constant, model.discount, settings.rollout_cycles, *self._tables)
        words = words_of(rng) if model.is_trusted else None  # functions of others may want any kind of number
        draws = rng if words is None else words
        with model.told:
            depth = self._kernel(
                model.arrays, bound_arrays, belief.states, belief.weights, tree, workspace, descents, parameters, draws
            )
        if words is not None:
            go_on(rng, words)
        self._depth = max(self._depth, depth)
        return tree

    def _grow_until(self, belief: Belief, end: float, rng: np.random.Generator) -> Tree:
        """Grow until another look at the clock might come too late; at least one descent per action."""
        descents = len(belief.model.actions)
        self._memory(belief, descents)
        while True:
            begin = time.perf_counter()
            tree = self._grow(belief, descents, rng)
            now = time.perf_counter()
            next_look = (now - begin) / descents * DESCENTS_PER_LOOK
            descents = DESCENTS_PER_LOOK
            if now + 2 * next_look > end or tree.size[0] + descents > tree.nodes.size:
                return tree

    def _memory(self, belief: Belief, descents: int) -> tuple[Tree, Workspace]:
        """The tree, with room for this many more descents, and the working memory."""
        model, settings = belief.model, self.settings
        tree = self._tree
        used = 1 if tree is None else int(tree.size[0])
        if tree is None or used + descents > tree.nodes.size:
            backup, exploration = BACKUPS[settings.backup], EXPLORATIONS[settings.exploration]
            shape = len(model.actions), len(model.observations)
            record = node_type(*shape, backup.with_chances, exploration.with_spread, keeps_rewards(model))
            capacity = used + descents
            if settings.seconds is not None:
                capacity = max(capacity, min(MAX_NODES, MAX_BYTES // record.itemsize))
            larger = new_tree(capacity, record)
            if tree is not None:
                larger.nodes[:used], larger.size[0] = tree.nodes[:used], used
            self._tree = tree = larger
        capacity = tree.nodes.size
        width = belief.states.shape[1]
        if self._workspace is None or self._workspace.nodes.size < capacity or self._workspace.state.size != width:
            self._workspace = new_workspace(width, len(model.outcomes), capacity)
        if self._tables[0].size <= capacity:
            self._tables = tables(capacity + 1)
        return tree, self._workspace


def _same_task(first: Pomdp, second: Pomdp) -> bool:
    """Whether a tree of one problem can be reused for the other: the same task, perhaps for other workers."""
    same = all(getattr(first, names) == getattr(second, names) for names in ("actions", "outcomes", "observations"))
    return same and keeps_rewards(first) == keeps_rewards(second)


class PomcpSettings(PolicySettings):
    """Monte-Carlo tree search: backup `mean` is POMCP, `max` POMCP-Max; it ends after `descents` or `seconds`."""

    kind: Literal["pomcp"] = Field(description="Monte-Carlo tree search over beliefs.")
    backup: BackupName = Field(
        description="How an action's value follows from its descents: their mean (POMCP), the best action below (max: "
        "POMCP-Max), or exact expectations."
    )
    exploration_constant: float = Field(
        ge=0,
        le=1e9,
        description="Constant c of UCB1; the unit is that of the return, or none if exploration is scaled.",
    )
    exploration: ExplorationName = Field(
        default="fixed",
        description="Whether c is used as it is (fixed) or multiplied by the spread of the returns so far (scaled).",
    )
    leaf_value: LeafValueName = Field(default="none", description=LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=ROLLOUT_CYCLES)
    descents: int | None = Field(
        default=None,
        ge=1,
        le=1_000_000,
        description="Budget of a decision: descents of the tree, at least one per action. Give this or seconds.",
    )
    seconds: float | None = Field(
        default=None, gt=0, le=3600, description="Budget of a decision: planning time in s. Give this or descents."
    )
    reuse_tree: bool = Field(
        default=False,
        description="Whether the next decision continues with the part of the tree below what was done and seen.",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.descents is None) == (self.seconds is None):
            raise ValueError("needs a budget: either descents or seconds")
        return self

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return PomcpPolicy(self)
