"""What a station file may say, what it becomes, and how mistakes are told."""

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from commands import fatplan, refused
from conftest import ROOT

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.motion.action import Orientation
from fatigue_planner.motion.payload import CarriedMass, HandForce
from fatigue_planner.station.assessment import Doing, Outcome
from fatigue_planner.station.bound_experiments import BoundExperiment, bound_experiments
from fatigue_planner.station.changes import changed_stations
from fatigue_planner.station.experiments import Part, parts_of
from fatigue_planner.station.judging import shift_of, stated
from fatigue_planner.station.limits import Breach
from fatigue_planner.station.loader import load_station, parse_station
from fatigue_planner.station.schema import Station
from fatigue_planner.station.workers import facts_of, worker_of

# What an ergonomist wrote, without the keys that no tool can guess (`handed`, `actions`).
WISH = """\
name: line7
workers:
  small_woman: {percentile: 5, sex: female, handedness: right}
  tall_man: {percentile: 95, sex: male}
  lefty: {height_m: 1.78, mass_kg: 80, sex: male, handedness: left}
tools: {screwdriver: 1.2 kg, gun: 3 kg}
cycle: {duration_s: 42}
places:
  overhead: {x: 0.35, y: -0.15, z: 1.85, tool: screwdriver}
  door: {x: 0.45, y: -0.2, z: 0.9, tool: gun}
  plug: {x: 0.4, y: -0.2, z: 0.35}
operations:
  fit: {places: [overhead, door, plug], seconds: 25}
shift: {hours: 8, breaks: [{at_min: 120, minutes: 15}]}
"""


def station(**more: Any) -> Station:
    return parse_station(as_read({**yaml.safe_load(WISH), **more}), "wish")


def as_read(value: Any) -> Any:
    """Lists as fatplan reads them."""
    if isinstance(value, dict):
        return {key: as_read(item) for key, item in value.items()}
    return tuple(map(as_read, value)) if isinstance(value, list) else value


def part_of(said: Station, hands: tuple[str, ...]) -> Part:
    return next(part for part in parts_of(said) if part.hands == hands)


def test_the_wish_is_a_station() -> None:
    said = station()
    woman, man, lefty = (facts_of(said, name) for name in said.workers)
    assert (woman.stature_m, woman.mass_kg) == (1.525, 58.0)
    assert (man.stature_m, round(man.mass_kg)) == (1.87, 96)
    assert (lefty.stature_m, lefty.mass_kg, lefty.measured) == (1.78, 80, True)
    assert 50 < lefty.stature_percentile < 75  # ANSUR's quartile is 1.802 m
    assert (woman.strength, man.strength) == ("average_woman", "average_man")


def test_a_station_becomes_experiments_that_simulate_takes(tmp_path: Path) -> None:
    (tmp_path / "wish.yaml").write_text(WISH)
    texts = fatplan("assess", tmp_path / "wish.yaml", "--explain").stdout.split("---\n")
    assert len(texts) == 2  # right hands, left hands
    for text, part in zip(texts, parts_of(load_station(tmp_path / "wish.yaml")), strict=True):
        file = tmp_path / "part.yaml"
        file.write_text(text)
        experiment = load_experiment(file)
        asked = [request.digest for request in reaction_requests(part.experiment)]
        assert [request.digest for request in reaction_requests(experiment)] == asked
        assert experiment.name == part.experiment.name
    said = fatplan("assess", "wish.yaml", "--explain", "--output", "parts", cwd=tmp_path).stdout
    assert said.split() == ["parts/line7_fit_right.yaml", "parts/line7_fit_left.yaml"]
    assert [load_experiment(tmp_path / file).name for file in said.split()] == ["line7_fit_right", "line7_fit_left"]


def test_limits_bind_the_experiments() -> None:
    """What breaks one is in none of them: most places, then most ways; where nothing is left, there is none."""
    limits = [{"measure": "upper_arm_elevation", "above_deg": 60, "at_most_s": 1.0}]
    places = {name: {"x": 0.35, "y": -0.1, "z": z} for name, z in (("low", 0.6), ("door", 1.1), ("high", 1.6))}
    said = station(places=places, operations={"fit": {"places": list(places), "seconds": 5}}, limits=limits,
                   workers={"woman": {"percentile": 50, "sex": "female"}}, ways=["arm", "back"])  # fmt: skip

    def bound(**broken: list[str]) -> BoundExperiment:
        """By place, the ways that break the limit there; all other motions are reached, but for high with the back."""
        outcomes = []
        for place, way in product(places, said.ways):
            found = Outcome(Doing("woman", "fit", place, way), ("right",), "reached")
            if (place, way) == ("high", "back"):
                found = replace(found, kind="missed")
            elif way in broken.get(place, []):
                found = replace(found, breaches=(Breach(0, 3.0),))
            outcomes.append(found)
        (only,) = bound_experiments(said, outcomes)
        return only

    def kept(found: BoundExperiment) -> tuple[list[str], list[str]]:
        assert found.experiment is not None
        return list(found.experiment.actions), list(found.experiment.preferences)

    assert kept(bound()) == (["low", "door", "high"], ["arm", "back"]) and bound().left_out == ()
    found = bound(high=["arm"])
    assert kept(found) == (["low", "door"], ["arm", "back"])  # the other way does not reach it
    why = "upper_arm_elevation above 60 degrees for 3.0 s in a cycle; limit 1 allows 1 s"
    assert found.left_out == (f"action high: woman at high, arm: {why}",)
    found = bound(low=["back"], door=["back"])
    assert kept(found) == (["low", "door", "high"], ["arm"]) and found.left_out[0].startswith("preference back: woman")
    found = bound(low=["arm", "back"], door=["arm", "back"], high=["arm"])
    assert found.experiment is None and len(found.left_out) >= 4


def test_a_worker_faces_the_place_if_the_feet_are_free_and_the_left_hander_in_the_mirror() -> None:
    turned = {"x": 0.4, "y": -0.3, "z": 0.9, "orientation_deg": {"x": 10, "y": -80, "z": 20}}
    said = station(places={"door": turned}, operations={"fit": {"places": "door", "seconds": 25, "tool": "gun"}})
    left = part_of(said, ("left",)).experiment.actions["door"]
    assert left.right_hand is None and left.left_hand is not None and left.left_hand.position_m is not None
    assert left.left_hand.position_m.model_dump() == {"x": 0.5, "y": 0, "z": 0.875}
    ahead = np.array(
        [[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]
    )  # a turn to the left, as the worker turned to the right
    mirror, own = np.diag([1.0, -1.0, 1.0]), ahead @ Orientation(x=10, y=-80, z=20).rotation()
    right = part_of(said, ("right",)).experiment.actions["door"].right_hand
    assert right is not None and right.orientation_deg is not None
    assert right.orientation_deg.rotation() == pytest.approx(own, abs=1e-5)
    assert left.left_hand.orientation_deg is not None
    assert left.left_hand.orientation_deg.rotation() == pytest.approx(mirror @ own @ mirror, abs=1e-5)
    assert left.loads == (CarriedMass(kind="mass", hand="left", mass_kg=3),)
    fixed = part_of(station(feet="fixed"), ("left",)).experiment.actions["door"]
    assert fixed.left_hand is not None and fixed.left_hand.position_m is not None
    assert fixed.left_hand.position_m.y == -0.2
    upper_arms = part_of(said, ("left",)).experiment.preferences["back"].tasks
    assert [task.segment for task in upper_arms] == ["left_upper_arm"]


def test_the_centre_of_mass_of_a_tool_goes_with_the_hand() -> None:
    """As stated in the right hand, in the mirror in the left one; not where two hands hold one thing."""
    tools = {"drill": {"mass_kg": 2, "centre_of_mass_m": {"x": 0.1, "y": 0.03, "z": -0.02}}}
    places = {"door": {"x": 0.4, "y": 0, "z": 1}}
    operation = {"places": "door", "seconds": 10, "tool": "drill"}
    said = station(places=places, tools=tools, operations={"fit": operation})
    for side, y in (("right", 0.03), ("left", -0.03)):
        (mass,) = part_of(said, (side,)).experiment.actions["door"].loads
        assert isinstance(mass, CarriedMass) and mass.hand == side
        assert mass.centre_of_mass_m.vector().tolist() == [0.1, y, -0.02]
    with pytest.raises(ExperimentError, match="fit holds it with both hands"):
        station(places=places, tools=tools, operations={"fit": operation | {"hand": "both"}})


def test_both_hands_share_what_they_hold_and_stand_apart() -> None:
    tools = {"bar": {"mass_kg": 4, "force_n": {"z": -40}}}
    operation = {"places": "door", "seconds": 10, "hand": "both", "tool": "bar", "grip_width_m": 0.4}
    said = station(places={"door": {"x": 0.4, "y": 0, "z": 1}}, tools=tools, operations={"lift": operation})
    (part,) = parts_of(said)
    action = part.experiment.actions["door"]
    apart = {side: goal.path()[0].position_m.y for side, goal in action.goals().items()}
    assert apart == {"right": -0.2, "left": 0.2}
    masses = {load.hand: load.mass_kg for load in action.loads if isinstance(load, CarriedMass)}
    assert masses == {"right": 2, "left": 2}
    forces = [load for load in action.loads if isinstance(load, HandForce)]
    times = np.array([0, 3, 3.2, 8, 12.8, 13, 17])
    assert forces[0].at(times)[:, 2].tolist() == [0, 0, -20, -20, -20, 0, 0]


def test_strength_is_a_percentile_of_its_own() -> None:
    workers = {"anna": {"percentile": 95, "sex": "female", "strength_percentile": 5}}
    facts = facts_of(station(workers=workers), "anna")
    assert facts.strength == "average_woman:p5" and facts.stature_m == 1.74


def test_a_percentile_of_strength_may_have_many_digits() -> None:
    said = station(workers={"bob": {"percentile": 50, "sex": "male", "strength_percentile": 12.345}})
    assert worker_of(said, "bob").strength.endswith(":p12.35")


def test_nearer_is_nearer_whichever_way_the_worker_faces() -> None:
    said = station(
        places={name: {"x": 0.1, "y": 0.6, "z": 1.2, "tool": "gun"} for name in ("overhead", "door", "plug")}
    )
    nearer = next(changed for change, changed in changed_stations(said) if str(change) == "door 10 cm nearer")
    near, far = (np.hypot(each.places["door"].x, each.places["door"].y) for each in (nearer, said))
    assert far - near == pytest.approx(0.1, abs=1e-4)


def test_the_other_hand_of_either_is_tried_where_it_is_no_mirror_image() -> None:
    operations = {"fit": {"places": ["overhead", "door", "plug"], "seconds": 25}}

    def tried(**more: Any) -> list[Station]:
        said = station(operations=operations, **more)
        return [new for change, new in changed_stations(said) if str(change) == "fit with the other hand"]

    assert tried() == []  # who faces the place would do the same in the mirror
    (changed,) = tried(feet="fixed")
    hands = {worker: part.hands for part in parts_of(changed) for worker in part.workers}
    assert hands == {"small_woman": ("left",), "tall_man": ("left",), "lefty": ("right",)}


def test_the_force_of_the_work_is_not_mirrored() -> None:
    """A part that pushes to the left pushes the left-hander, who works in the mirror, to the left, too."""
    tools = {"gun": {"mass_kg": 3, "force_n": {"y": 40}}}
    places = {"door": {"x": 0.4, "y": 0, "z": 1.1, "tool": "gun"}}
    said = station(tools=tools, places=places, operations={"fit": {"places": "door", "seconds": 5}})
    for hand in ("right", "left"):
        (force,) = (load for load in part_of(said, (hand,)).experiment.actions["door"].loads if load.kind == "force")
        assert max(point.y for point in force.force_n) == 40


def test_the_stations_own_population_counts() -> None:
    own = {"female": {"stature_m": {"mean": 1.66, "sd": 0.065}, "mass_kg": {"mean": 68.7, "sd": 12.0}}}
    said = station(population=own, workers={"anna": {"percentile": 5, "sex": "female"}})
    assert facts_of(said, "anna").stature_m == pytest.approx(1.66 - 1.6449 * 0.065, abs=1e-4)
    with pytest.raises(ExperimentError, match=r"workers.bob.percentile: population.male is not given"):
        station(population=own, workers={"bob": {"percentile": 5, "sex": "male"}})


def test_other_work_of_the_shift_is_heard() -> None:
    said = {"hours": 4, "other_work": {"press": {"strain_index": 6.2, "hours": 3}}}
    assert [(each.strain_index, each.hours) for each in shift_of(station(shift=said)).other_work] == [(6.2, 3)]


def test_the_indicators_hear_what_is_stated() -> None:
    operation = {"places": "door", "seconds": 5, "coupling": "poor", "times_per_cycle": 2}
    breaks = [{"at_min": 100, "minutes": 15}, {"at_min": 240, "minutes": 30}]
    said = station(operations={"fit": operation}, shift={"hours": 8, "breaks": breaks})
    assert (stated(said, "fit").coupling, stated(said, "fit").times_per_cycle) == ("poor", 2)
    shift = shift_of(said)
    assert shift.cycle_s == 42 and shift.hours == pytest.approx(7.25)
    worked = [(60 * spell.work_h, 60 * spell.break_h) for spell in shift.spells]
    assert worked == [pytest.approx(spell) for spell in ((100, 15), (125, 30), (210, 0))]
    assert shift.hours == pytest.approx(sum(spell.work_h for spell in shift.spells))
    assert shift_of(said.model_copy(update={"shift": None})).hours is None
    assert [spell.work_h for spell in shift_of(station(shift={"hours": 24})).spells] == [24]
    together = [{"at_min": 0, "minutes": 10}, {"at_min": 60, "minutes": 30}, {"at_min": 90, "minutes": 30}]
    spells = shift_of(station(shift={"hours": 3, "breaks": together})).spells
    assert [(60 * one.work_h, 60 * one.break_h) for one in spells] == [(50, 60), (60, 0)]


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"tools": {"gun": "3kilo"}}, "tools.gun: '3kilo': a tool is its mass with the unit, 1.2 kg, or {mass_kg: 1.2"),
        ({"tools": {"gun": 3}}, "tools.gun: 3 has no unit; write 3 kg or {mass_kg: 3}."),
        ({"cycle": {"duration_s": 30}}, "cycle.duration_s = 30: the operations take 32 s with their ways"),
        ({"places": {"door": {"x": 0.4, "y": 0, "z": 1}}}, "operations.fit.places: 'overhead' is not one of door"),
        ({"workers": {"a": {"sex": "male"}}}, "workers.a: give either percentile (of stature) or height_m (measured)"),
        ({"cycle": {"duration_s": 42, "work_s": 25}}, "cycle.work_s: unknown key; allowed are"),
        ({"ways": ["arm", "arm"]}, "ways: names a way twice"),
        ({"shift": {"hours": 8, "breaks": [{"at_min": 470, "minutes": 15}]}}, "shift: breaks: the one at 470 min"),
        ({"tool": {"gun": "3 kg"}}, "tool: unknown key; did you mean 'tools'?"),
        ({"shift": {"hours": 8, "breaks": [{"at_min": 0, "minutes": 480}]}}, "shift: breaks: they leave nothing of"),
        ({"places": {"door": {"x": 2.0, "y": 2.0, "z": 1}}}, "places.door: is 2.83 m from between the feet"),
        ({"tools": {"gun": {"mass_kg": 3, "force_n": {"x": 900, "y": 900}}}}, "tools.gun.force_n: is 1273 N; at most"),
    ],
)  # fmt: skip
def test_mistakes_are_named_with_the_right_way(more: dict[str, Any], expected: str) -> None:
    with pytest.raises(ExperimentError) as error:
        station(**more)
    assert expected in str(error.value)


def test_a_file_in_an_experiments_words_is_told_a_stations(tmp_path: Path) -> None:
    content = yaml.safe_load(WISH)
    del content["places"], content["operations"]
    content["actions"] = {"overhead": {"right_hand": {"position_m": {"x": 0.35, "y": -0.15, "z": 1.8}}}}
    content["workers"]["lefty"]["handed"] = content["workers"]["lefty"].pop("handedness")
    (tmp_path / "wish.yaml").write_text(yaml.safe_dump(content))
    message = refused(2, "assess", tmp_path / "wish.yaml")
    assert "places: {overhead: {x: 0.35, y: -0.15, z: 1.8}}" in message
    assert "workers.lefty.handed: unknown key; did you mean 'handedness'?" in message
    assert "is missing" not in message
    line = ROOT / "experiments" / "car_line.yaml"
    for command in ("simulate", "view", "benchmark", "live serve"):
        message = refused(2, *command.split(), line)
        assert "is a station, not an experiment; it is for `fatplan assess` and `schedule`" in message
        assert f"`fatplan assess {line} --explain --output DIR` writes the experiments it becomes." in message
    assert "is a study" in refused(2, "assess", ROOT / "experiments" / "sensitivity.yaml")
    content = yaml.safe_load(WISH) | {"cycle": {"duration_s": 42.01}}
    (tmp_path / "wish.yaml").write_text(yaml.safe_dump(content))
    message = refused(2, "assess", tmp_path / "wish.yaml")
    assert "cycle.duration_s = 42.01: should be a multiple of 0.02 s" in message


def test_a_grid_of_places_is_a_map() -> None:
    rack = {
        "x": {"from": 0.3, "to": 0.4, "count": 2},
        "y": -0.1,
        "z": {"from": 1.0, "to": 1.4, "count": 3},
        "tool": "gun",
    }
    said = station(places={"rack": rack, "floor": {"x": 0.4, "y": 0, "z": 0.4}},
                   operations={"fit": {"places": ["floor", "rack"], "seconds": 5}})  # fmt: skip
    names = ["rack_x0.3_z1", "rack_x0.3_z1.2", "rack_x0.3_z1.4", "rack_x0.4_z1", "rack_x0.4_z1.2", "rack_x0.4_z1.4"]
    assert said.operations["fit"].places == ("floor", *names)
    at = said.places["rack_x0.4_z1.2"]
    assert (at.x, at.y, at.z, at.tool, at.map) == (0.4, -0.1, 1.2, "gun", "rack")
    assert said.places["floor"].map is None
    aside = {"x": 0.4, "y": {"from": -0.2, "to": 0.2, "count": 2}, "z": 1.0}
    named = station(places={"a-b": aside}, operations={"fit": {"places": "a-b", "seconds": 5}})
    assert named.operations["fit"].places == ("a-b_ym0.2", "a-b_y0.2")
    single = station(places={"rack": rack}, operations={"fit": {"places": "rack", "seconds": 5}})
    assert single.operations["fit"].places == tuple(names)


@pytest.mark.parametrize(
    ("rack", "expected"),
    [
        ({"x": 0.3, "y": 0, "z": {"from": 1.0, "to": 1.4}}, "places.rack.z.count: is missing. A range is {from: 0.3"),
        ({"x": {"from": 0.3, "to": 0.5, "count": 20}, "y": 0, "z": {"from": 1.0, "to": 1.4, "count": 20}},
         "places.rack: its grid has 400 points"),
        ({"x": 0.3, "y": 0, "z": {"from": 1.0, "to": 1.4, "count": 2}},
         "places.rack: its grid makes rack_z1.4, a name that another place has."),
    ],
)  # fmt: skip
def test_a_faulty_grid_of_places_is_named(rack: dict[str, Any], expected: str) -> None:
    with pytest.raises(ExperimentError) as error:
        station(places={"rack": rack, "rack_z1.4": {"x": 0.3, "y": 0, "z": 1.4}},
                operations={"fit": {"places": "rack", "seconds": 5}})  # fmt: skip
    assert expected in str(error.value)


def test_a_map_shows_one_place_at_a_point() -> None:
    at = {"x": 0.3, "y": 0, "z": 1.0, "map": "rack"}
    with pytest.raises(ExperimentError, match="a is at the same point of map rack"):
        station(places={"a": at, "b": at}, operations={"fit": {"places": ["a", "b"], "seconds": 5}})
    station(places={"a": at, "b": at | {"map": "other"}}, operations={"fit": {"places": ["a", "b"], "seconds": 5}})


def test_what_init_writes_is_a_station(tmp_path: Path) -> None:
    assert fatplan("init", "anna", "--station", cwd=tmp_path).returncode == 0
    done = fatplan("validate", "anna.yaml", cwd=tmp_path)
    assert done.stdout == "anna.yaml: ok; a station with 1 operation, 3 workers.\n"
    # what is commented out is right, too
    text = (tmp_path / "anna.yaml").read_text()
    for key in ("population", "gun", "  coupling", "  actions_per_minute", "  effort_share", "  shock", "limits"):
        text = text.replace(f"\n# {key.strip()}:", f"\n{key.strip()}:").replace(f"\n# {key}", f"\n  {key}")
    text = text.replace("\ngun:", "\n  gun:")
    (tmp_path / "anna.yaml").write_text(text)
    all_of_it = load_station(tmp_path / "anna.yaml")
    assert all_of_it.limits and all_of_it.population and all_of_it.tools["gun"].force_n
    assert all_of_it.operations["screw"].effort_share == 0.3


def test_the_shipped_station_is_valid() -> None:
    assert load_station(Path("car_line")).name == "car_line"
