"""The relations a file of claims can name; to add one: write it (see `relation.Relation`) and add a line."""

from fatigue_planner.study.claims.relations.at_least_as_good import AtLeastAsGood
from fatigue_planner.study.claims.relations.best_outperforms import BestOutperforms
from fatigue_planner.study.claims.relations.better_mean import BetterMean
from fatigue_planner.study.claims.relations.equivalent import Equivalent
from fatigue_planner.study.claims.relations.less_sensitive import LessSensitive
from fatigue_planner.study.claims.relations.low_performance import LowPerformance
from fatigue_planner.study.claims.relations.no_single_best import NoSingleBest
from fatigue_planner.study.claims.relations.not_significantly_different import NotSignificantlyDifferent
from fatigue_planner.study.claims.relations.relation import Relation
from fatigue_planner.study.claims.relations.same_mean import SameMean
from fatigue_planner.study.claims.relations.significantly_outperforms import SignificantlyOutperforms

RELATIONS: dict[str, Relation] = {
    "significantly_outperforms": SignificantlyOutperforms(),
    "better_mean": BetterMean(),
    "low_performance": LowPerformance(),
    "not_significantly_different": NotSignificantlyDifferent(),
    "equivalent": Equivalent(),
    "same_mean": SameMean(),
    "at_least_as_good": AtLeastAsGood(),
    "best_outperforms": BestOutperforms(),
    "less_sensitive": LessSensitive(),
    "no_single_best": NoSingleBest(),
}
