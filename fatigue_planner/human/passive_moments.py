"""Passive joint moments: what ligaments, capsules and relaxed muscles exert, by the angles of the joints.

Hip, knee and ankle flexion: Riener & Edrich, "Identification of passive elastic joint moments in the lower
extremities", J. Biomech. 32(5), 1999, where muscles that span two joints couple them. All others: exponentials towards
the ends of the range, from data/passive_moments.yaml.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.jit import compiled
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.skeleton import DATA, DEGREES_OF_FREEDOM, SIDES, without_side

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]

DEGREE = 180 / np.pi
# The men whom the moments are taken to be those of; for others they grow with mass times stature, as their muscles and
# lever arms do, and as Anderson et al. (2007) scale strengths (assumed).
REFERENCE_MASS_KG, REFERENCE_STATURE_M = 75.0, 1.75


class EndMoments(Settings):
    """The passive moments of a degree of freedom at both ends of its range, in N.m towards the middle."""

    min_nm: float = Field(ge=0)
    max_nm: float = Field(ge=0)
    per_rad: float = Field(gt=0)
    source: str


class PassiveTable(NamedTuple):
    """What `passive_moments` needs: for all degrees of freedom (39,) the ends of the range in rad, the moments there in
    N.m and the exponents in 1/rad; the indices (2, 3) of hip, knee and ankle flexion of both legs; and by how much all
    moments are multiplied.
    """

    lower: Vector
    upper: Vector
    at_lower_nm: Vector
    at_upper_nm: Vector
    per_rad: Vector
    legs: Indices
    scale: float


@cache
def passive_table(person: Anthropometry) -> PassiveTable:
    """The parameters of all passive moments of a worker."""
    rows = load_data(DATA / "passive_moments.yaml", dict[str, EndMoments])
    none = EndMoments(min_nm=0, max_nm=0, per_rad=1, source="riener_edrich")
    own = [rows.get(without_side(name), none) for name in DEGREES_OF_FREEDOM]
    legs = [[DEGREES_OF_FREEDOM.index(f"{side}_{j}_flexion") for j in ("hip", "knee", "ankle")] for side in SIDES]
    return PassiveTable(
        *position_limits(),
        np.array([row.min_nm for row in own], dtype=float),
        np.array([row.max_nm for row in own], dtype=float),
        np.array([row.per_rad for row in own], dtype=float),
        np.array(legs),
        person.mass_kg * person.stature_m / (REFERENCE_MASS_KG * REFERENCE_STATURE_M),
    )


def passive_moments_of(person: Anthropometry, angles: Vector) -> Vector:
    """The passive moments (39,) N.m of a worker at joint angles (39,) rad."""
    moments = np.empty(len(angles))
    passive_moments(passive_table(person), angles, moments, np.zeros((len(angles), len(angles))))
    return moments


@compiled
def passive_moments(table: PassiveTable, angles: Vector, moments: Vector, slopes: Matrix) -> None:
    """Write the passive moments (39,) N.m at joint angles (39,) rad and their derivatives (39, 39) N.m/rad.

    `slopes` must be 0 where a moment does not depend on an angle; only the other entries are written. A row is a
    moment, a column an angle. The sign of a moment is that of the degree of freedom.
    """
    for i in range(len(angles)):
        below = table.at_lower_nm[i] * np.exp(-table.per_rad[i] * (angles[i] - table.lower[i]))
        above = table.at_upper_nm[i] * np.exp(table.per_rad[i] * (angles[i] - table.upper[i]))
        moments[i] = below - above
        slopes[i, i] = -table.per_rad[i] * (below + above)
    for leg in range(len(table.legs)):
        hip, knee, ankle = table.legs[leg]
        h, k, a = DEGREE * angles[hip], DEGREE * angles[knee], DEGREE * angles[ankle]
        extended, flexed = np.exp(1.4655 - 0.0034 * k - 0.0750 * h), np.exp(1.3403 - 0.0226 * k + 0.0305 * h)
        moments[hip] = extended - flexed + 8.072
        slopes[hip, hip] = DEGREE * (-0.0750 * extended - 0.0305 * flexed)
        slopes[hip, knee] = DEGREE * (-0.0034 * extended + 0.0226 * flexed)
        straight = np.exp(1.800 + 0.0460 * a - 0.0352 * k + 0.0217 * h)
        bent, stopped = np.exp(-3.971 + 0.0004 * a + 0.0495 * k - 0.0128 * h), np.exp(2.220 - 1.50 * k)
        moments[knee] = straight - bent - 4.820 + stopped
        slopes[knee, ankle] = DEGREE * (0.0460 * straight - 0.0004 * bent)
        slopes[knee, knee] = DEGREE * (-0.0352 * straight - 0.0495 * bent - 1.50 * stopped)
        slopes[knee, hip] = DEGREE * (0.0217 * straight + 0.0128 * bent)
        pointed, raised = np.exp(-7.9763 - 0.1949 * a + 0.0008 * k), np.exp(2.1016 + 0.0843 * a - 0.0176 * k)
        moments[ankle] = pointed - raised + 1.792
        slopes[ankle, ankle] = DEGREE * (-0.1949 * pointed - 0.0843 * raised)
        slopes[ankle, knee] = DEGREE * (0.0008 * pointed + 0.0176 * raised)
    moments *= table.scale
    slopes *= table.scale
