"""What a simulation cannot know of the work and the user states: every key may be left out, which means unknown."""

from typing import Literal

from pydantic import Field

from fatigue_planner.core.settings import Settings

Coupling = Literal["good", "fair", "poor", "unacceptable"]
Handling = Literal["none", "lift", "lower", "push", "pull", "carry"]


class Circumstances(Settings):
    """What is stated of one operation. What is left out is unknown: a score that needs it becomes a range."""

    load_kg: float | None = Field(
        default=None,
        ge=0,
        le=200,
        description="Load in kg in the working hands together. Default: what the hands of the simulated worker bear, "
        "masses and forces / 9.81.",
    )
    handling: Handling = Field(
        default="none",
        description="What is done with the load. none: it is used or held; lift or lower: it is set down at another "
        "height; push or pull: it stands on the ground and moves; carry: it is walked with.",
    )
    times_per_cycle: float = Field(
        default=1, gt=0, le=1000, description="How often the operation is done in a cycle, without unit."
    )
    actions_per_minute: float | None = Field(
        default=None,
        ge=0,
        le=300,
        description="How many similar actions of the hands there are per minute of the operation, without unit: screws "
        "driven, parts placed. Above 4 the work is repeated (RULA, REBA).",
    )
    effort_share: float | None = Field(
        default=None,
        ge=0,
        le=1,
        description="How hard the hand grips, as a fraction of the worker's largest grip: 0.1 barely, 0.3 noticeable, "
        "0.5 obvious, 0.8 with changed expression of the face.",
    )
    omni_effort: float | None = Field(
        default=None,
        ge=0,
        le=10,
        description="Effort of the hand on the OMNI-RES scale, without unit: 0 extremely easy, 2 easy, 4 somewhat "
        "easy, 6 somewhat hard, 8 hard, 10 extremely hard.",
    )
    effort_s: float | None = Field(
        default=None, gt=0, le=600, description="How long one effort of the hand lasts, in s. Default: the work phase."
    )
    coupling: Coupling | None = Field(
        default=None,
        description="How the hand holds the object. good: a handle that fits, or a loose part round which the fingers "
        "close; fair: no good handle, but the fingers bend to 90 degrees under it; poor: bulky, sharp, slippery, soft, "
        "or no place for the fingers; unacceptable: not to be held safely.",
    )
    shock: bool | None = Field(
        default=None, description="Whether the hands get shocks or the force rises suddenly: impact wrench, hammer."
    )
    rapid_changes: bool | None = Field(
        default=None, description="Whether the work makes rapid large changes of posture, or the base is unstable."
    )
    shoulder_raised: bool | None = Field(
        default=None, description="Whether the shoulder is drawn up; the simulated body has no shoulder blade."
    )
    arm_supported: bool = Field(
        default=False, description="Whether the working arm rests on something. The simulated one does not."
    )
    trunk_supported: bool = Field(
        default=False, description="Whether the trunk rests on something. The simulated one does not."
    )
    head_supported: bool = Field(
        default=False, description="Whether the head rests on something. The simulated one does not."
    )
    placed_carefully: bool | None = Field(
        default=None,
        description="Whether the load has to be placed with care, so that NIOSH's equation counts its place, too.",
    )
    end_height_m: float | None = Field(
        default=None, ge=0, le=3, description="Height in m at which what is lifted or lowered is set down."
    )
    end_distance_m: float | None = Field(
        default=None,
        ge=0,
        le=2,
        description="Horizontal distance in m from the ankles' middle to the hands where the load is set down.",
    )
    moved_m: float | None = Field(
        default=None, gt=0, le=100, description="How far in m a load is pushed, pulled or carried."
    )


class Spell(Settings):
    """A time of this work without a break, and the break after it."""

    work_h: float = Field(gt=0, le=24, description="Time of this work without a break, in h.")
    break_h: float = Field(default=0, ge=0, le=24, description="Break, or other light work, after that, in h.")


class OtherWork(Settings):
    """What the same hands do elsewhere in the shift."""

    strain_index: float = Field(
        gt=0,
        le=1000,
        description="Its composite strain index at its hours, without unit: what the page of that station says.",
    )
    hours: float = Field(
        gt=0, le=24, description="How long it is done in the shift in hours, breaks excluded, without unit."
    )


class Shift(Settings):
    """What is stated of the shift. What is left out is unknown."""

    cycle_s: float | None = Field(
        default=None,
        gt=0,
        le=28_800,
        description="Time in s from one beginning of the cycle to the next. Default: all operations, one by one.",
    )
    hours: float | None = Field(
        default=None, gt=0, le=24, description="How long the cycle is repeated in a shift, in h."
    )
    spell_h: float | None = Field(
        default=None, gt=0, le=24, description="Longest time of this work between two breaks, in h."
    )
    break_h: float | None = Field(
        default=None, ge=0, le=12, description="Break, or other light work, after that, in h."
    )
    spells: tuple[Spell, ...] = Field(
        default=(), max_length=100, description="All times of this work in their order, instead of spell_h and break_h."
    )
    other_work: tuple[OtherWork, ...] = Field(
        default=(), max_length=20, description="What the same hands do elsewhere in the shift: job rotation."
    )
