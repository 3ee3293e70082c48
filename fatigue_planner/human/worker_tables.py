"""Tables that describe a worker: segments, ranges of motion, strengths."""

import numpy as np
import pandas as pd

from fatigue_planner.human.joint_data import maximum_torque, position_limits
from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM


def segment_frame(worker: Worker) -> pd.DataFrame:
    """One row per body: mass, centre of mass in the body's frame, moments of inertia about it."""
    body = worker.anthropometry()
    rows = []
    for name in BODIES:
        segment = body.segment(name)
        rows.append(
            {"segment": name, "mass_kg": segment.mass_kg}
            | dict(zip(("com_x_m", "com_y_m", "com_z_m"), segment.com_m, strict=True))
            | dict(zip(("inertia_x_kgm2", "inertia_y_kgm2", "inertia_z_kgm2"), segment.inertia_kgm2, strict=True))
        )
    return pd.DataFrame(rows)


def joint_frame(worker: Worker) -> pd.DataFrame:
    """One row per degree of freedom: range of motion and maximum torques.

    Raises DataFileError for an unknown strength set.
    """
    lower, upper = position_limits()
    positive, negative = maximum_torque(worker.strength).vectors()
    return pd.DataFrame(
        {
            "degree_of_freedom": DEGREES_OF_FREEDOM,
            "lowest_deg": np.degrees(lower),
            "highest_deg": np.degrees(upper),
            "maximum_torque_positive_nm": positive,
            "maximum_torque_negative_nm": negative,
        }
    )
