"""Faults to be planted in the sources, one at a time, and the tests that must notice them.

Each is one of those that are easily made and hardly seen: a sign, a factor, a forgotten step, a check left out.
"""

from typing import NamedTuple


class Fault(NamedTuple):
    """In a file of the package `old`, which stands there once, becomes `new`; one of the tests must fail."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


def _f(name: str, file: str, old: str, new: str, *tests: str) -> Fault:
    return Fault(name, file, old, new, tests)


HUMAN = (
    _f(
        "the neck's mass counts twice",
        "human/anthropometry.py",
        "mass -= segment_table().neck_mass_percent.value / 100 * self.mass_kg",
        "mass -= 0.0",
        "human/test_human.py::test_segment_masses_sum_to_the_body",
    ),
    _f(
        "limbs' centres of mass from the wrong end",
        "human/anthropometry.py",
        "com = np.array([0.0, 0.0, -along * length])",
        "com = np.array([0.0, 0.0, -(1 - along) * length])",
        "human/test_human.py::test_upper_body_centre_of_mass_matches_the_hand_calculation",
        "human/test_human.py::test_static_shoulder_torque_by_hand",
        "output/test_human_page.py::test_torques_agree_with_a_calculation_by_hand_for_any_body",
    ),
    _f(
        "moments of inertia about the wrong axes",
        "human/anthropometry.py",
        "radii = np.array([sagittal, transverse, longitudinal])",
        "radii = np.array([longitudinal, transverse, sagittal])",
        "human/test_human.py::test_moments_of_inertia_by_hand",
    ),
    _f(
        "the left side not mirrored",
        "human/skeleton.py",
        '"+x": "-x", "-x": "+x"',
        '"+x": "+x", "-x": "-x"',
        "human/test_human.py::test_left_and_right_are_mirror_images",
    ),
    _f(
        "right and left shoulder and hip exchanged",
        "human/anthropometry.py",
        '{"right": -1.0, "left": 1.0}',
        '{"right": 1.0, "left": -1.0}',
        "human/test_human.py::test_joint_centres_are_not_as_wide_as_the_body",
    ),
    _f(
        "gravity upwards",
        "human/model.py",
        "np.array([0.0, 0.0, -GRAVITY_MPS2])",
        "np.array([0.0, 0.0, GRAVITY_MPS2])",
        "human/test_human.py::test_static_shoulder_torque_by_hand",
    ),
    _f(
        "a direction's strength taken for the other's",
        "human/joint_data.py",
        'negative_nm=tuple(entries[freedom, "negative"]',
        'negative_nm=tuple(entries[freedom, "positive"]',
        "human/test_strength_sets.py::test_what_is_not_listed_comes_from_the_base",
        "human/test_strength_sets.py::test_a_side_goes_before_both_sides_and_a_file_before_its_base",
    ),
    _f(
        "a joint's upper limit in degrees",
        "human/joint_data.py",
        "np.radians([row.max for row in rows])",
        "np.array([row.max for row in rows])",
        "human/test_human.py::test_posture_refuses_unknown_joints_and_impossible_angles",
    ),
)

MOTION = (
    _f(
        "friction pyramid around the cone, not in it",
        "motion/contact.py",
        "friction_coefficient / np.sqrt(2)",
        "friction_coefficient",
        "motion/test_motion.py::test_wrench_cone_is_that_of_forces_at_four_corners",
    ),
    _f(
        "sign of the ground's part in the joint torques",
        "motion/assembly.py",
        "torque_map[j, nv + i] = -contact_jacobian",
        "torque_map[j, nv + i] = contact_jacobian",
        "motion/test_motion.py::test_condensed_program_solves_the_papers_program",
    ),
    _f(
        "a force on the hand pushes the other way",
        "motion/body_state.py",
        "self.nonlinear_effects - force_n @",
        "self.nonlinear_effects + force_n @",
        "motion/test_scenes.py::test_a_weight_pushes_as_the_mass_it_belongs_to",
    ),
    _f(
        "the error of the other hand",
        "motion/verification.py",
        "own = [both[SIDES.index(side)] for both in hand_poses]",
        "own = [both[1 - SIDES.index(side)] for both in hand_poses]",
        "motion/test_scenes.py::test_both_hands_without_orientation",
    ),
    _f(
        "the tool in the right hand, whichever works",
        "motion/schedule.py",
        "return tool.hand or first",
        'return tool.hand or "right"',
        "motion/test_scenes.py::test_the_tool_is_in_the_hand_that_works",
    ),
    _f(
        "the lower limit sees the joint move the wrong way",
        "motion/joint_limits.py",
        "position[i] - lower[i], -velocity[i]",
        "position[i] - lower[i], velocity[i]",
        "motion/test_motion.py::test_a_joint_driven_hard_at_its_limit_never_passes_it",
    ),
    _f(
        "the reach's speed is not the slope of its path",
        "motion/minimum_jerk.py",
        "30 * x**2 * (1 - x) ** 2",
        "30 * x**2 * (1 - x)",
        "motion/test_motion.py::test_minimum_jerk_has_its_known_peaks",
    ),
    _f(
        "positions from the old velocity",
        "motion/simulator.py",
        "self.configuration, self.time_step_s * self.velocity",
        "self.configuration, self.time_step_s * (self.velocity - self.time_step_s * acceleration)",
        "motion/test_scenes.py::test_both_hands_without_orientation",
    ),
    _f(
        "a hand that is nowhere (NaN) is accurate",
        "motion/quality.py",
        "not self.work_hand_error_m <= required.hand_error_m",
        "self.work_hand_error_m > required.hand_error_m",
        "motion/test_motion.py::test_no_number_of_a_quality_may_be_none",
    ),
    _f(
        "an answer that violates constraints is optimal",
        "motion/quadratic_program.py",
        "total: float = violation + stationarity + complementarity",
        "total: float = stationarity + complementarity",
        "motion/test_motion.py::test_an_answer_that_is_not_optimal_is_not_believed",
    ),
    _f(
        "power balance without what the joints do",
        "motion/replay.py",
        "work = run.actuator_work_j + run.contact_work_j",
        "work = run.contact_work_j",
        "motion/test_scenes.py::test_both_hands_without_orientation",
    ),
)

REACTIONS = (
    _f(
        "a reaction's key without the versions of the numerical libraries",
        "reactions/key.py",
        '"sources": self.sources, "versions": self.versions}',
        '"sources": self.sources}',
        "reactions/test_reactions.py::test_the_key_of_a_reaction_knows_sources_and_libraries",
    ),
    _f(
        "a reaction's key without the version of the solvers",
        "reactions/key.py",
        '"pin", "casadi", ',
        '"pin", ',
        "reactions/test_reactions.py::test_the_key_of_a_reaction_knows_sources_and_libraries",
    ),
    _f(
        "a reaction's key without the sources",
        "reactions/key.py",
        '"settings": self.settings, "sources": self.sources,',
        '"settings": self.settings,',
        "reactions/test_reactions.py::test_the_key_of_a_reaction_knows_sources_and_libraries",
    ),
    _f(
        "a reaction's key without the body's data",
        "core/files.py",
        'if path.suffix in {".py", ".yaml"}',
        'if path.suffix in {".py"}',
        "reactions/test_reactions.py::test_the_key_of_a_reaction_knows_sources_and_libraries",
    ),
    _f(
        "a stored reaction is used whatever the accuracy asked for",
        "reactions/reaction.py",
        "faults = stored.quality.faults(self.accuracy)",
        "faults: list[str] = []",
        "reactions/test_reactions.py::test_accuracy_decides_when_a_motion_is_read_and_nothing_is_simulated_again",
    ),
    _f(
        "the checksum of a reaction's file is not checked",
        "reactions/hdf5_layout.py",
        "content[:CHECKSUM_BYTES] == _checksum(content)",
        "content.startswith(_CHECKSUM_MARK)",
        "reactions/test_reactions.py::test_a_damaged_entry_is_refused_and_set_aside_and_made_again[flip]",
    ),
    _f(
        "the hash of a reaction's numbers is not checked",
        "reactions/hdf5_layout.py",
        "if _content_sha256(reaction).encode() != sha256.item():",
        "if not sha256.item():",
        "reactions/test_reactions.py::test_numbers_altered_behind_a_valid_checksum_are_noticed",
    ),
    _f(
        "a reaction under another's name is accepted",
        "reactions/cache.py",
        'if not path.stem.endswith(f"-{reaction.digest[:DIGEST_LENGTH]}"):',
        "if not path.stem:",
        "reactions/test_reactions.py::test_an_entry_under_a_wrong_name_is_refused",
    ),
)

FATIGUE = (
    _f(
        "sign of recovery",
        "fatigue/model.py",
        "- R * self.rest_s",
        "+ R * self.rest_s",
        "fatigue/test_fatigue.py::test_agonist_tires_while_antagonist_recovers",
    ),
    _f(
        "what a run tires is not recovered from later",
        "fatigue/model.py",
        "np.exp(-k * later_dose - R * later_rest)",
        "np.exp(-k * later_dose)",
        "fatigue/test_fatigue.py::test_cycle_map_is_the_integral_of_equation_2",
    ),
    _f(
        "fatigue is not bounded by 1",
        "fatigue/model.py",
        "offset += -np.expm1(-k * dose) *",
        "offset += k * dose *",
        "fatigue/test_fatigue.py::test_cycle_map_is_the_integral_of_equation_2",
    ),
    _f(
        "no threshold",
        "fatigue/model.py",
        "tiring = share > parameters.threshold",
        "tiring = share > 0 * parameters.threshold",
        "fatigue/test_fatigue.py::test_load_at_the_threshold_recovers_and_just_above_tires",
    ),
    _f(
        "a load at the threshold tires",
        "fatigue/model.py",
        "share > parameters.threshold",
        "share >= parameters.threshold",
        "fatigue/test_fatigue.py::test_load_at_the_threshold_recovers_and_just_above_tires",
    ),
    _f(
        "the torque's absolute value loads both muscles",
        "fatigue/model.py",
        "np.hstack([np.maximum(torque_nm, 0), np.maximum(-torque_nm, 0)])",
        "np.hstack([np.abs(torque_nm), np.abs(torque_nm)])",
        "fatigue/test_fatigue.py::test_agonist_tires_while_antagonist_recovers",
    ),
    _f(
        "the strength of the other direction",
        "fatigue/parameters.py",
        "np.concatenate(strength.vectors())",
        "np.concatenate(strength.vectors()[::-1])",
        "fatigue/test_fatigue.py::test_every_entry_has_the_strength_of_its_direction",
    ),
)

POMDP = (
    _f(
        "the worker prefers what tires most",
        "pomdp/boltzmann.py",
        "math.exp(-expertise * excess)",
        "math.exp(expertise * excess)",
        "pomdp/test_pomdp.py::test_choice_is_equation_4",
    ),
    _f(
        "an expert chooses like a novice",
        "pomdp/boltzmann.py",
        "return 0.0",
        "return 1.0",
        "pomdp/test_pomdp.py::test_choice_at_both_ends_and_ties",
    ),
    _f(
        "the cost's mean is over the live entries only",
        "pomdp/fatigue_pomdp.py",
        "len(actions), 1 / ever.size\n",
        "len(actions), 1 / ever.sum()\n",
        "pomdp/test_pomdp.py::test_no_entry_that_is_never_loaded_changes_anything",
    ),
    _f(
        "chances of observations transposed",
        "pomdp/fatigue_pomdp.py",
        "arrays.observation[preference, observation]",
        "arrays.observation[observation, preference]",
        "pomdp/test_pomdp.py::test_recognition_is_as_the_matrix_says",
    ),
    _f(
        "another worker's cycle maps",
        "pomdp/fatigue_pomdp.py",
        "(worker * arrays.n_actions + action) *",
        "action *",
        "pomdp/test_hidden_worker.py::test_every_worker_has_rows_of_its_own",
    ),
    _f(
        "the belief forgets what it was",
        "pomdp/beliefs/exact.py",
        "np.log(weights[i]) + np.log(probability)",
        "np.log(probability)",
        "pomdp/test_beliefs.py::test_belief_is_bayes_rule_over_whole_histories",
    ),
    _f(
        "weights kept beside resampled particles",
        "pomdp/beliefs/particles.py",
        "weights=equal, log_weights=np.zeros(count), history=history)",
        "weights=equal, log_weights=self.log_weights, history=history)",
        "pomdp/test_particles.py::test_systematic_resampling_is_unbiased_and_even",
    ),
    _f(
        "particles are not weighted by what was seen",
        "pomdp/beliefs/particles.py",
        "log_weights = self.log_weights + log_likelihood",
        "log_weights = self.log_weights + 0 * np.isinf(log_likelihood)",
        "pomdp/test_particles.py::test_posterior_is_the_exact_one",
    ),
    _f(
        "every proposed worker is accepted",
        "pomdp/beliefs/hidden_worker.py",
        "accepted = rng.random(count) < np.exp(np.minimum(likelihood - log_likelihood, 0))",
        "accepted = rng.random(count) < 2",
        "pomdp/test_hidden_worker.py::test_rejuvenation_leaves_workers_and_their_pasts_as_they_are_distributed",
    ),
    _f(
        "plans for ever discount one cycle too few",
        "pomdp/cyclic_plans.py",
        "weight = [discount * after - 1 / entries for after in square]",
        "weight = [after - 1 / entries for after in square]",
        "pomdp/test_cyclic_plans.py::test_values_are_the_returns_of_the_plans",
    ),
)

PLANNERS = (
    _f(
        "greedy chooses what tires most",
        "planners/baselines.py",
        "int(values.argmax()), values, 1",
        "int(values.argmin()), values, 1",
        "planners/test_planners.py::test_greedy_is_the_one_step_optimum",
    ),
    _f(
        "the search avoids what it has not explored",
        "planners/pomcp/ucb.py",
        "node.value[action] + width *",
        "node.value[action] - width *",
        "planners/test_search.py::test_golden_tree_by_hand",
    ),
    _f(
        "exploration is scaled by the variance",
        "planners/pomcp/ucb.py",
        "deviation = np.sqrt(node.spread * parameters.inverse[max(node.visited - 1, 1)])",
        "deviation = node.spread * parameters.inverse[max(node.visited - 1, 1)]",
        "pomdp/test_metamorphic.py::test_another_unit_of_reward_changes_no_decision",
    ),
    _f(
        "the exact backup takes unknown successors for worth nothing",
        "planners/pomcp/backups.py",
        "parameters.discount * future / known",
        "parameters.discount * future",
        "planners/test_search.py::test_exact_backup_knows_the_chances_everywhere",
    ),
    _f(
        "the lookahead does not discount",
        "planners/expectimax.py",
        "// observations] += parameters.discount * best",
        "// observations] += best",
        "planners/test_exact_values.py::test_lookahead_is_exact_in_the_tiger_problem",
    ),
    _f(
        "rollouts discount their first reward",
        "planners/pomcp/leaf_values.py",
        "= workspace.state, workspace.moved, workspace.probabilities\n    gained, weight = 0.0, 1.0",
        "= workspace.state, workspace.moved, workspace.probabilities\n    gained, weight = 0.0, parameters.discount",
        "planners/test_leaf_values.py::test_a_rollout_is_worth_what_its_policy_is_worth",
    ),
    _f(
        "the tree kept is that of another observation",
        "planners/pomcp/policy.py",
        '["child"][0, action, observation])',
        '["child"][0, action, 1 - observation])',
        "planners/test_planners.py::test_the_kept_tree_is_the_subtree_and_the_search_goes_on_from_it",
    ),
)

BENCHMARK = (
    _f(
        "conditions share their seed",
        "core/random_streams.py",
        "key = (condition, n_cycles, trial)",
        "key = (n_cycles, trial)",
        "study/test_benchmark.py::test_worlds_depend_on_condition_length_and_trial_only",
    ),
    _f(
        "all trials are the same",
        "core/random_streams.py",
        "key = (condition, n_cycles, trial)",
        "key = (condition, n_cycles)",
        "study/test_benchmark.py::test_worlds_depend_on_condition_length_and_trial_only",
    ),
    _f(
        "the world depends on the policy",
        "study/benchmark/cell.py",
        "world = draw_random_numbers(self.seed, self.condition, self.n_cycles, trial)\n",
        "world = draw_random_numbers(self.seed, self.condition + self.policy, self.n_cycles, trial)\n",
        "study/test_benchmark.py::test_a_run_is_lived_through_again_from_its_actions",
    ),
    _f(
        "the planner draws from the world's stream",
        "study/benchmark/cell.py",
        'random_stream(self.seed, "planner", self.condition, self.n_cycles, trial, self.policy)',
        'random_stream(self.seed, "preference", self.condition, self.n_cycles, trial)',
        "study/test_benchmark.py::test_every_run_plans_with_draws_of_its_own",
    ),
    _f(
        "policies share the planner's stream",
        "study/benchmark/cell.py",
        'random_stream(self.seed, "planner", self.condition, self.n_cycles, trial, self.policy)',
        'random_stream(self.seed, "planner", self.condition, self.n_cycles, trial)',
        "study/test_benchmark.py::test_every_run_plans_with_draws_of_its_own",
    ),
    _f(
        "the return is not discounted",
        "study/benchmark/trial.py",
        "total -= discount * costs[cycle]",
        "total -= costs[cycle]",
        "study/test_benchmark.py::test_return_is_the_discounted_sum_by_hand",
    ),
    _f(
        "the first reward is discounted, too",
        "study/benchmark/trial.py",
        "total, discount = 0.0, 1.0",
        "total, discount = 0.0, model.discount",
        "study/test_benchmark.py::test_return_is_the_discounted_sum_by_hand",
    ),
    _f(
        "the belief is not updated",
        "study/benchmark/trial.py",
        "belief = belief.update(action, observation, rng)",
        "belief.update(action, observation, rng)",
        "study/test_benchmark.py::test_return_is_the_discounted_sum_by_hand",
    ),
    _f(
        "a cell's key without the seed",
        "study/benchmark/cell.py",
        "[self.condition, self.n_cycles, self.policy, self.seed]",
        "[self.condition, self.n_cycles, self.policy]",
        "study/test_benchmark.py::test_key_of_a_cell_knows_what_decides_its_trials",
    ),
    _f(
        "a cell's key without the sources",
        "study/benchmark/cell.py",
        '"sources": digest_of_package(*SOURCES)',
        '"sources": ""',
        "study/test_benchmark.py::test_key_of_a_cell_knows_sources_and_libraries",
    ),
    _f(
        "a cell's key without the libraries' versions",
        "study/benchmark/cell.py",
        '"versions": versions_of(*NUMERICAL_LIBRARIES)',
        '"versions": {}',
        "study/test_benchmark.py::test_key_of_a_cell_knows_sources_and_libraries",
    ),
    _f(
        "a trial may have two results",
        "study/benchmark/store.py",
        "if earlier != job.outcome(result):",
        "if not earlier:",
        "study/test_benchmark.py::test_two_results_of_one_trial_are_an_error_that_shows_both",
    ),
    _f(
        "the hash of a part is not checked",
        "core/files.py",
        'intact = content.pop("sha256") == digest_of(content) and text == _sealed(content)',
        'intact = bool(content.pop("sha256"))',
        "study/test_benchmark.py::test_every_flipped_bit_in_a_part_is_noticed",
    ),
    _f(
        "another cell's trials are accepted",
        "study/benchmark/store.py",
        'if content is not None and content["digest"] == digest:',
        "if content is not None:",
        "study/test_benchmark.py::test_a_part_of_another_cell_is_set_aside",
    ),
    _f(
        "a regret that is not discounted",
        "study/benchmark/regret.py",
        "cell.scenario.model.discount ** np.arange(len(actions))",
        "1.0 ** np.arange(len(actions))",
        "study/test_regret.py::test_regret_is_what_the_decisions_lose_by_the_references_values",
    ),
    _f(
        "a bound of the highest cost",
        "planners/bounds/quadratics.py",
        "> 0, low, high)",
        "< 0, low, high)",
        "planners/test_bounds.py::test_the_minimum_over_a_box",
    ),
)

STATISTICS = (
    _f(
        "an unpaired test for pairs",
        "study/statistics/contrasts.py",
        "paired_p=paired_p(differences)",
        "paired_p=student_p(pairs.first, pairs.second)",
        "study/test_contrasts.py::test_means_and_t_tests_by_mpmath",
    ),
    _f(
        "pairs by their place, not by their trial",
        "study/statistics/pairing.py",
        "np.array([self.returns[trial] for trial in trials])",
        "np.array(list(self.returns.values()))",
        "study/test_contrasts.py::test_neither_the_order_of_rows_nor_the_other_policies_matter",
    ),
    _f(
        "Holm's correction is not monotone",
        "study/statistics/multiple_testing.py",
        "np.maximum.accumulate(steps * p_values[order])",
        "steps * p_values[order]",
        "study/test_contrasts.py::test_holm_is_monotone_and_never_below_the_raw_value",
    ),
    _f(
        "a one-sided test",
        "study/statistics/hypothesis_tests.py",
        "float(2 * stdtr(",
        "float(stdtr(",
        "study/test_contrasts.py::test_means_and_t_tests_by_mpmath",
    ),
    _f(
        "a standard deviation with n",
        "study/statistics/intervals.py",
        "values.std(ddof=1)",
        "values.std(ddof=0)",
        "study/test_contrasts.py::test_means_and_t_tests_by_mpmath",
    ),
    _f(
        "sign of the equivalence margin",
        "study/statistics/hypothesis_tests.py",
        "- margin) / standard_error(differences)",
        "+ margin) / standard_error(differences)",
        "study/test_contrasts.py::test_equivalence_by_mpmath",
    ),
    _f(
        "ties count as wins",
        "study/statistics/effect_sizes.py",
        "np.mean(differences == 0) / 2",
        "np.mean(differences == 0)",
        "study/test_contrasts.py::test_where_nothing_is_left_to_chance_the_difference_is_exact",
        "study/test_contrasts.py::test_means_and_t_tests_by_mpmath",
        "study/test_contrasts.py::test_swapped_policies_swap_every_sign",
    ),
    _f(
        "the worst policy first",
        "study/statistics/comparison.py",
        "key=lambda name: -float(",
        "key=lambda name: float(",
        "study/test_statistics.py::test_student_t_by_hand",
    ),
    _f(
        "an interval's ends stay when policies change places",
        "study/statistics/contrast.py",
        "{one: -getattr(self, other) for pair in _MIRRORED",
        "{one: -getattr(self, one) for pair in _MIRRORED",
        "study/test_contrasts.py::test_swapped_policies_swap_every_sign",
    ),
    _f(
        "the gain of the planner is its loss",
        "study/sensitivity/gains.py",
        "saved = baseline - planner",
        "saved = planner - baseline",
        "study/test_sensitivity.py::test_gains_by_hand",
    ),
)

CLAIMS = (
    _f(
        "low performance is being better",
        "study/claims/relations/low_performance.py",
        "return [(other, policy) for",
        "return [(policy, other) for",
        "study/test_claims.py::test_low_performance_is_the_others_being_better",
    ),
    _f(
        "claims are judged without correction",
        "study/claims/analyses/modern.py",
        "        if contrast.holm_p < self.level:",
        "        if contrast.paired_p < self.level:",
        "study/test_claims.py::test_significance_is_corrected_for_the_family",
    ),
    _f(
        "the first comparison decides",
        "study/claims/relations/relation.py",
        "answer = all_of(part.judgement.answer for part in parts)",
        "answer = parts[0].judgement.answer",
        "study/test_claims.py::test_one_failing_comparison_decides_and_else_one_open",
    ),
    _f(
        "the room to win is a share of the bound",
        "study/claims/headroom.py",
        "(cost - bound) / cost",
        "(cost - bound) / bound",
        "study/test_claims.py::test_room_to_win_by_hand",
    ),
)

RESULTS = (
    _f(
        "the hash of a table is not checked",
        "core/provenance.py",
        "if note.sha256.get(file) != _sha256(",
        "if not _sha256(",
        "study/test_results.py::test_wrong_rows_are_named",
    ),
    _f(
        "a return that its actions do not come to",
        "study/benchmark/results.py",
        "course is None or course.discounted_return != discounted_return",
        "course is None",
        "study/test_results.py::test_rows_of_another_configuration_are_named",
    ),
    _f(
        "rows may stand twice",
        "study/benchmark/tables.py",
        "if twice.any():",
        "if twice.all():",
        "study/test_benchmark.py::test_table_is_tidy_and_checked_on_reading",
    ),
    _f(
        "an unknown key is ignored",
        "core/settings.py",
        'extra="forbid"',
        'extra="ignore"',
        "experiment/test_experiment.py::test_mistakes_are_named",
    ),
    _f(
        "a file is written in its place",
        "core/files.py",
        "        write(temporary)\n",
        "        write(path)\n        temporary.write_bytes(path.read_bytes())\n",
        "core/test_files.py::test_a_failed_write_leaves_the_old_file_and_no_other",
    ),
)

FAULTS = (
    *HUMAN, *MOTION, *REACTIONS, *FATIGUE, *POMDP, *PLANNERS, *BENCHMARK, *STATISTICS, *CLAIMS, *RESULTS
)  # fmt: skip
