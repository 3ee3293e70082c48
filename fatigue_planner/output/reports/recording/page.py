"""The page of an imported recording: verdict, markers, residuals, angles and torques, and what was inferred."""

from collections.abc import Sequence

import numpy as np

from fatigue_planner.core.text import fixed, listing, percent
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Block, Code, Points, Section, Table, Text, page
from fatigue_planner.output.reports.recording.courses import (
    PANELS,
    angles_figure,
    largest,
    markers_figure,
    residuals_figure,
    torques_figure,
)
from fatigue_planner.reactions.reaction import ReactionRequest
from fatigue_planner.reactions.recorded import PhaseQuality, RecordedQuality
from fatigue_planner.recordings.imports.imported import Imported
from fatigue_planner.recordings.inference.interpret import Interpreted

WORST = 12  # markers in the table


def recording_page(
    made: Imported,
    found: Interpreted,
    request: ReactionRequest,
    figures: FigureFolder,
    use: str,
) -> str:
    """The page (HTML); its figures and tables go to the folder. use: what to write into the experiment."""
    name, quality = made.reaction.name, made.quality
    verdict, faults = request.verdict(quality), request.faults(quality)
    words = {
        "ok": "Nothing is to be said against its torques.",
        "degraded": "Its torques are used; this is to be known of them:",
        "failed": "Its torques cannot be believed, and are not used:",
    }[verdict]
    summary: list[Block] = [Text(f"Verdict: `{verdict}`. {words}")]
    if told := faults or quality.remarks():
        summary.append(Points(told))
    summary += [Text("An experiment names it so:"), Code(use)]
    sections = [
        Section("The verdict by phase", [_phases(quality)]),
        _markers(made, figures),
        _residuals(made, quality, figures),
        _angles(made, figures),
        _torques(made, quality, figures),
        _read(found, made),
    ]
    return page(f"Recording of {name}", f"import {made.key}", summary, sections)


def _phases(quality: RecordedQuality) -> Table:
    """What is known of the phases, a column for each."""
    rows = [
        ["recorded", *(f"{phase.from_s:.2f} to {phase.to_s:.2f} s" for phase in quality.phases)],
        ["pace against the cycle's", *(f"× {phase.stretch:.2f}" for phase in quality.phases)],
        ["markers, RMS", *(f"{1000 * phase.marker_rms_m:.1f} mm" for phase in quality.phases)],
        ["worst marker, RMS", *(f"{1000 * one.worst_marker_m:.1f} mm ({one.worst_marker})" for one in quality.phases)],
        ["longest without a marker", *(_unseen(phase) for phase in quality.phases)],
        ["force that no plate explains", *(_share(phase.residual_force_share, 1) for phase in quality.phases)],
        ["moment that no plate explains", *(_moment(phase) for phase in quality.phases)],
        ["unmeasured contact", *(_share(phase.unmeasured_share) for phase in quality.phases)],
        ["both feet on one plate", *(_share(phase.one_plate_share) for phase in quality.phases)],
        ["feet slide", *(f"{100 * phase.foot_slide_m:.1f} cm" for phase in quality.phases)],
    ]
    header = ["", *(phase.name for phase in quality.phases)]
    return Table("What each phase shows; forces as shares of the weight. A dash: no plate measured it.", header, rows)


def _unseen(phase: PhaseQuality) -> str:
    return f"{phase.unseen_s:.2f} s ({phase.unseen_body.replace('_', ' ')})" if phase.unseen_s else "0 s"


def _share(share: float | None, digits: int = 0) -> str:
    return "–" if share is None else percent(share, digits)


def _moment(phase: PhaseQuality) -> str:
    return "–" if phase.residual_moment_nm is None else f"{phase.residual_moment_nm:.1f} N·m"


def _markers(made: Imported, figures: FigureFolder) -> Section:
    figure, table = markers_figure(made)
    each = sorted(made.track.marker_rms_m.items(), key=lambda item: -item[1])
    seen = np.isfinite(made.track.distance_m).mean(axis=0)
    share = dict(zip(made.track.labels, seen.tolist(), strict=True))
    bodies = dict(zip(made.calibration.markers.labels, made.calibration.markers.bodies, strict=True))
    words = f"RMS {table['rms_mm'].mean():.1f} mm on average; at most {table['farthest_mm'].max():.0f} mm."
    picture = figures.add(
        "markers", figure, table,
        "Distances between the markers and their places on the body. Dotted: where phases begin and end.", words,
    )  # fmt: skip
    rows = [
        [label, bodies[label].replace("_", " "), fixed(1000 * value), percent(share[label], 0)]
        for label, value in each[:WORST]
    ]
    caption = f"The markers farthest from their places{'' if len(each) <= WORST else f', {WORST} of {len(each)}'}."
    return Section("Markers", [picture, Table(caption, ["marker", "on", "RMS, mm", "seen"], rows)])


def _residuals(made: Imported, quality: RecordedQuality, figures: FigureFolder) -> Section:
    title = "What no plate explains"
    if not quality.has_plates:
        return Section(title, [Text("There are no plates: how both feet share the ground's force is assumed.")])
    figure, table = residuals_figure(made)
    force = [name for name in map(str, table) if name.startswith("force")]
    moment = [name for name in map(str, table) if name.startswith("moment")]
    words = f"Largest: {largest(table, force)} N; {largest(table, moment)} N·m."
    caption = "The force, and the moment about the hips, that the motion needs beside what the plates show."
    return Section(title, [figures.add("residuals", figure, table, caption, words)])


def _angles(made: Imported, figures: FigureFolder) -> Section:
    figure, table = angles_figure(made)
    words = f"Largest: {largest(table, [f'{name}_deg' for names in PANELS.values() for name in names])}°."
    return Section("Joint angles", [figures.add("angles", figure, table, "Joint angles of every frame.", words)])


def _torques(made: Imported, quality: RecordedQuality, figures: FigureFolder) -> Section:
    figure, table = torques_figure(made)
    shown = [f"{name}_nm" for names in PANELS.values() for name in names if table[f"{name}_nm"].notna().any()]
    words = f"Largest: {largest(table, shown)} N·m."
    blocks: list[Block] = []
    if quality.assumed_joints:
        joints = listing([joint.replace("_", " ") for joint in quality.assumed_joints])
        blocks.append(Text(f"No marker shows {joints}: no torque is shown there."))
    caption = "Joint torques of every frame, at the recorded pace, with what passive tissue bears."
    return Section("Joint torques", [*blocks, figures.add("torques", figure, table, caption, words)])


def _read(found: Interpreted, made: Imported) -> Section:
    rows = [[one.what, one.value, one.source] for one in (*found.findings, *made.findings)]
    told = [f"Fault {remark.fault}: {remark.text}" for remark in (*found.remarks, *made.remarks)]
    blocks: list[Block] = [Table("What was read or inferred, and from what.", ["what", "value", "from"], rows)]
    return Section("What was read", [*blocks, *_points(told)])


def _points(told: Sequence[str]) -> list[Block]:
    return [Points(told)] if told else []
