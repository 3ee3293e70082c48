"""The policy of a search with a sparse tree: for problems with optional functions, and for POMCPOW."""

import time
from typing import Any, NamedTuple

import numpy as np

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import inlined, kernel, specialised
from fatigue_planner.planners.policy import Decision, Policy, explained
from fatigue_planner.planners.pomcp.buffers import TINY, SearchParameters, Workspace, new_workspace, tables
from fatigue_planner.planners.pomcp.kernels import (
    BACKUPS,
    EXPLORATIONS,
    LEAF_VALUES,
    BackupName,
    ExplorationName,
    LeafValueName,
    bound_arrays_for,
    rules,
)
from fatigue_planner.planners.pomcp.sparse import actions, widening
from fatigue_planner.planners.pomcp.sparse.search import grow
from fatigue_planner.planners.pomcp.sparse.tree import SparseTree, larger, new_tree, node_type
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.parts import without_prior
from fatigue_planner.pomdp.problem import Pomdp

# How many descents a search with a time limit makes between two looks at the clock.
DESCENTS_PER_LOOK = 50
# Room for nodes at the beginning of a search; it doubles when it is used up.
FEWEST, MOST_AT_FIRST = 256, 65_536
# A dense tree with so many children per node and action would be mostly empty memory.
MAX_DENSE_CHILDREN = 4096


class Search(NamedTuple):
    """What a search is made of, and when it ends; `widening`: see `widening.Widening`, None for POMCP."""

    backup: BackupName
    exploration: ExplorationName
    exploration_constant: float
    leaf_value: LeafValueName
    rollout_cycles: int
    descents: int | None
    seconds: float | None
    widening: tuple[float, float, float, float] | None = None


def needs_a_sparse_tree(model: Pomdp) -> bool:
    """Whether the dense search does not know what the problem says of itself, or would have no room for it."""
    return model.dynamics.shapes_the_search or len(model.actions) * len(model.observations) > MAX_DENSE_CHILDREN


def search_kernel(model: Pomdp, search: Search) -> Any:
    """`search.grow` for a problem and these parts, compiled."""
    backup, exploration, legal = BACKUPS[search.backup], EXPLORATIONS[search.exploration], rules(model)["is_legal"]
    wide = search.widening is not None
    choose = specialised(
        actions.best_legal_action,
        inlined,
        is_legal=legal,
        exploration_scale=actions.scale_of_returns if exploration.with_spread else actions.fixed_scale,
        actions_to_consider=widening.widened_actions if wide else widening.all_actions,
    )
    settle = specialised(actions.begin_with_prior, inlined, is_legal=legal, prior=model.dynamics.prior or without_prior)
    return specialised(
        grow,
        kernel,
        best_legal_action=choose,
        begin_with_prior=settle,
        follow=_widened(model) if wide else _followed(model),
        back_up=backup.back_up,
        note_return=exploration.note_return,
        leaf_value=LEAF_VALUES[search.leaf_value](model),
    )


def _followed(model: Pomdp) -> Any:
    return specialised(widening.follow, inlined, step=model.parts["step"], is_terminal=rules(model)["is_terminal"])


def _widened(model: Pomdp) -> Any:
    own = model.dynamics.observation_probability
    density = {"observation_probability": own, "CONTINUOUS": model.is_continuous}
    drawn = {"draw_observation": model.dynamics.draw_observation} if model.is_continuous else {}
    see = specialised(widening.see, inlined, **density, **drawn, N_OBSERVATIONS=len(model.observations))
    return specialised(
        widening.follow_widened,
        inlined,
        see=see,
        CONTINUOUS=model.is_continuous,
        likelihood=specialised(widening.likelihood, inlined, **density),
        is_terminal=rules(model)["is_terminal"],
        **{name: model.parts[name] for name in ("outcome_probabilities", "advance")},
    )


class SparsePolicy(Policy):
    """A tree search whose tree has as many nodes as it is visited, whatever can be observed."""

    def __init__(self, search: Search) -> None:
        self.search = search
        self.draws_at_random = search.seconds is not None or search.leaf_value == "random_rollout"
        self._model: Pomdp | None = None
        self._kernel: Any = None
        self._depth = 0

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action with the best estimated return of those tried: all are legal. Ties go to the first."""
        begin = time.perf_counter()
        tree = self.tree(belief, rng, begin)
        root = tree.nodes[0]
        visits = root["tried"].astype(np.int64) - tree.prior.astype(np.int64)
        values = root["value"].copy()
        values[visits == 0] = -np.inf
        action = int(values.argmax())
        values[visits == 0] = np.nan
        reason = explained(f"best estimated return after {visits.sum()} descents", belief)
        return Decision(action, values, visits, self._depth, time.perf_counter() - begin, reason)

    def tree(self, belief: Belief, rng: np.random.Generator, begin: float) -> SparseTree:
        """The search tree grown from a belief; `begin` is when the decision began (perf_counter).

        Raises ProblemError if the task has ended, or if there is no legal action.
        """
        search, model = self.search, belief.model
        if model is not self._model:
            self._check(model, belief)
            self._model, self._kernel = model, search_kernel(model, search)
        else:
            model.check_again(belief.states)
        belief = belief.going_on()
        legal = belief.legal_actions()
        record = node_type(legal.size, EXPLORATIONS[search.exploration].with_spread)
        wide = search.widening or (0.0, 0.0, 0.0, 0.0)
        seen = np.zeros(len(model.observations) if model.is_continuous else 1)
        capacity, width = min((search.descents or FEWEST) + 1, MOST_AT_FIRST), belief.states.shape[1]
        tree = new_tree(capacity, record, seen.size, 2 * capacity if search.widening else 0, width)
        workspace = new_workspace(width, len(model.outcomes), capacity)
        self._depth, done = 0, 0
        wanted = max(search.descents or 0, legal.size) if search.descents is None else search.descents
        pace = time.perf_counter()
        while True:
            arguments = belief.states, belief.weights, legal, np.ones(legal.size, bool), tree, workspace
            constants = widening.Widening(*wide, seen)
            parameters = self._parameters(model, tree)
            with model.told:
                more, depth = self._kernel(
                    model.arrays,
                    bound_arrays_for(model, search.leaf_value),
                    *arguments,
                    constants,
                    wanted - done,
                    parameters,
                    rng,
                )
            done, self._depth = done + more, max(self._depth, depth)
            if done < wanted:
                tree, workspace = _with_more_room(tree, workspace)
            elif search.seconds is None:
                return tree
            else:
                now = time.perf_counter()
                if now + 2 * DESCENTS_PER_LOOK * (now - pace) / done > begin + search.seconds:
                    return tree
                wanted += DESCENTS_PER_LOOK

    def _check(self, model: Pomdp, belief: Belief) -> None:
        if self.search.backup == "exact":
            raise ProblemError(
                "backup exact knows the probability of every observation below every node; a problem with many "
                "observations, or with more than three functions of its own, has backups mean and max."
            )
        if model.is_continuous and self.search.widening is None:
            raise ProblemError("pomcp has a node for every observation; this problem's are continuous: use pomcpow.")
        model.check_probabilities(belief.states)

    def _parameters(self, model: Pomdp, tree: SparseTree) -> SearchParameters:
        constant = max(self.search.exploration_constant, TINY)
        counts = tables(tree.nodes.size + actions.MOST_PRIOR_VISITS + 1)
        return SearchParameters(constant, model.discount, self.search.rollout_cycles, *counts)


def _with_more_room(tree: SparseTree, workspace: Workspace) -> tuple[SparseTree, Workspace]:
    """Twice the nodes, or twice the particles, whatever was used up."""
    nodes, particles = tree.used.tolist()
    capacity = 2 * tree.nodes.size if nodes == tree.nodes.size else tree.nodes.size
    pool = max(tree.sums.size, 2 * (2 * particles + capacity + 1)) if tree.sums.size else 0
    made = larger(tree, capacity, pool)
    return made, new_workspace(workspace.state.size, workspace.probabilities.size, capacity)
