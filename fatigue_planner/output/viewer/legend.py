"""What the colours and signs of the page mean, as a box in its corner."""

from fatigue_planner.output.viewer.scene import (
    CENTRE,
    COLOUR_STEPS,
    FORCE,
    FULL_SHARE,
    METRES_PER_NEWTON,
    METRES_PER_NEWTON_ON_A_HAND,
    OBJECT,
    TOOL,
    Colour,
    load_colour,
)

_STYLE = (
    "position:fixed;top:14px;right:14px;z-index:1;pointer-events:none;padding:10px 14px;border-radius:6px;"
    "background:rgba(255,255,255,.85);color:#222;font:13px/1.55 system-ui,sans-serif;max-width:290px"
)


def legend() -> str:
    """A box (HTML) that does not catch the mouse."""
    stops = [load_colour(FULL_SHARE * step / COLOUR_STEPS) for step in range(COLOUR_STEPS + 1)]
    bar = f"height:12px;margin-top:3px;background:linear-gradient(to right,{','.join(_css(stop) for stop in stops)})"
    scale = "".join(f"<span>{round(100 * FULL_SHARE * part)} %</span>" for part in (0, 0.5, 1))
    on_foot, on_hand = 100 * METRES_PER_NEWTON, 100 * METRES_PER_NEWTON_ON_A_HAND
    rows = (
        (CENTRE, "centre of mass, and the point of the ground below it"),
        (FORCE, f"force; 100 N are {on_foot:g} m on a foot, {on_hand:g} m on a hand"),
        (TOOL, "tool, or another mass in the hand"),
        (OBJECT, "where the hands have to go"),
    )
    signs = "".join(f'<div><span style="color:{_css(colour)}">&#9632;</span> {text}</div>' for colour, text in rows)
    return (
        f'<div id="legend" style="{_STYLE}"><div>spheres: largest torque at the joint, share of strength</div>'
        f'<div style="{bar}"></div><div style="display:flex;justify-content:space-between">{scale}</div>{signs}'
        "<div>space: play or pause; drag: orbit; wheel: zoom</div></div>"
    )


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
