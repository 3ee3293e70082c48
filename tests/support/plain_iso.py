"""ISO 11226 and EN 1005-4 once more, over a whole motion: lists and branches instead of arrays."""

from collections.abc import Callable, Iterator, Sequence

Seen = dict[str, float]
OK, WHILE, NOT = 0, 1, 2


def stretches(values: Sequence[bool]) -> Iterator[range]:
    """Where values are true without a break."""
    start = None
    for index, value in enumerate([*values, False]):
        if value and start is None:
            start = index
        elif not value and start is not None:
            yield range(start, index)
            start = None


def at_rest(values: Sequence[bool], at_work: Sequence[bool]) -> Iterator[range]:
    """The stretches of the work, or all of it where nothing interrupts it on the ways either."""
    if all(values):
        return stretches(values)
    return stretches([value and works for value, works in zip(values, at_work, strict=True)])


def iso_levels(motion: Sequence[Seen], step_s: float, at_work: Sequence[bool]) -> list[int]:
    """The level of each instant, with nothing supported and the shoulders down."""
    levels = [OK] * len(motion)

    def never(condition: Callable[[Seen], bool]) -> None:
        for stretch in at_rest([condition(seen) for seen in motion], at_work):
            if len(stretch) * step_s > 4:
                for index in stretch:
                    levels[index] = NOT

    def a_while(angle: str, free: float, most: float, longest_s: float) -> None:
        """Beyond the free angle, up to a time that falls to a minute at the largest and stays so."""
        for stretch in at_rest([free < seen[angle] for seen in motion], at_work):
            if len(stretch) * step_s <= 4:
                continue
            used = 0.0
            for index in stretch:
                below = most - min(most, motion[index][angle])
                used += step_s / (60 + (longest_s - 60) * below / (most - free))
            for index in stretch:
                levels[index] = max(levels[index], NOT if used > 1 else WHILE)

    a_while("trunk", 20, 60, 240)
    a_while("head", 25, 85, 480)
    for name, most in (("trunk", 60), ("head", 85)):
        never(lambda seen, name=name, most=most: seen[name] > most)  # type: ignore[misc]
        never(lambda seen, name=name: seen[name] < 0)  # type: ignore[misc]
    for name, most in (("trunk_twist", 10), ("trunk_side", 10), ("neck_twist", 45), ("neck_side", 10)):
        never(lambda seen, name=name, most=most: abs(seen[name]) > most)  # type: ignore[misc]
    never(lambda seen: seen["head"] - seen["trunk"] > 25)
    never(lambda seen: seen["head"] - seen["trunk"] < -5)
    for side in ("right", "left"):
        a_while(f"{side}_arm_raised", 20, 60, 180)
        bounds = {
            "arm_raised": (-1, 60), "arm_forward": (-10, 999), "arm_abducted": (-10, 999), "pronation": (-60, 60),
            "wrist": (-52.5, 56.25), "deviation": (-22.5, 15), "knee": (-1, 30),
        }  # fmt: skip
        for name, (least, most) in bounds.items():
            never(lambda seen, key=f"{side}_{name}", most=most: seen[key] > most)  # type: ignore[misc]
            never(lambda seen, key=f"{side}_{name}", least=least: seen[key] < least)  # type: ignore[misc]
    return levels


def en_levels(motion: Sequence[Seen], step_s: float, at_work: Sequence[bool]) -> list[int]:
    """The same for EN 1005-4, of a motion that is repeated without a pause."""
    levels = [OK] * len(motion)
    cycle_s = len(motion) * step_s

    def zone(
        condition: Callable[[Seen], bool],
        when_held: int,
        by_frequency: tuple[int, int, int],
        moved_beyond: Callable[[Seen], bool] | None = None,
    ) -> None:
        inside = [condition(seen) for seen in motion]
        beyond = [(moved_beyond or condition)(seen) for seen in motion]
        movements = len(list(stretches(beyond)))
        if beyond[0] and beyond[-1]:  # the next cycle goes on with it
            movements -= 1
        per_minute = movements / cycle_s * 60
        moved = by_frequency[0 if per_minute < 2 else 1 if per_minute < 10 else 2]
        for index, is_inside in enumerate(inside):
            if is_inside:
                levels[index] = max(levels[index], moved)
        for stretch in at_rest(inside, at_work):
            for index in stretch:
                levels[index] = max(levels[index], when_held if len(stretch) * step_s > 4 else OK)

    far = (NOT, (WHILE, NOT, NOT))
    zone(lambda seen: 20 < seen["trunk"] <= 60, WHILE, (OK, NOT, NOT), lambda seen: seen["trunk"] > 20)
    zone(lambda seen: seen["trunk"] > 60, *far)
    zone(lambda seen: seen["trunk"] < 0, *far)
    zone(lambda seen: seen["head"] > 40 or seen["head"] < 0, *far)
    for name, most in (("trunk_twist", 10), ("trunk_side", 10), ("neck_twist", 45), ("neck_side", 10)):
        zone(lambda seen, name=name, most=most: abs(seen[name]) > most, *far)  # type: ignore[misc]
    for side in ("right", "left"):
        raised = f"{side}_arm_raised"
        zone(
            lambda seen, key=raised: 20 < seen[key] <= 60,  # type: ignore[misc]
            WHILE,
            (OK, WHILE, NOT),
            lambda seen, key=raised: seen[key] > 20,  # type: ignore[misc]
        )
        zone(lambda seen, key=raised: seen[key] > 60, *far)  # type: ignore[misc]
        zone(lambda seen, key=f"{side}_arm_forward": seen[key] < -10, *far)  # type: ignore[misc]
    return levels
