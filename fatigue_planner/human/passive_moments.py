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
    """What the passive moments depend on: for all degrees of freedom (39,) the ends of the range in rad, the moments
    there in N.m and the exponents in 1/rad; the indices (2, 3) of hip, knee and ankle flexion of both legs; and by how
    much all moments are multiplied.
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
    """The passive moments (39,) N.m of a worker at joint angles (39,) rad; their signs are those of the angles."""
    moments = np.zeros(len(angles))
    add_passive_moments(passive_table(person), angles, moments)
    return moments


@compiled
def add_passive_moments(table: PassiveTable, angles: Vector, moments: Vector) -> None:
    """Add the passive moments at joint angles (39,) rad to moments (39,) N.m."""
    for i in range(len(angles)):
        if table.at_lower_nm[i] > 0 or table.at_upper_nm[i] > 0:
            below = table.at_lower_nm[i] * np.exp(-table.per_rad[i] * (angles[i] - table.lower[i]))
            above = table.at_upper_nm[i] * np.exp(table.per_rad[i] * (angles[i] - table.upper[i]))
            moments[i] += table.scale * (below - above)
    for leg in range(len(table.legs)):
        hip, knee, ankle = table.legs[leg]
        h, k, a = DEGREE * angles[hip], DEGREE * angles[knee], DEGREE * angles[ankle]
        at_hip = np.exp(1.4655 - 0.0034 * k - 0.0750 * h) - np.exp(1.3403 - 0.0226 * k + 0.0305 * h) + 8.072
        at_knee = np.exp(1.800 + 0.0460 * a - 0.0352 * k + 0.0217 * h)
        at_knee += -np.exp(-3.971 + 0.0004 * a + 0.0495 * k - 0.0128 * h) - 4.820 + np.exp(2.220 - 1.50 * k)
        at_ankle = np.exp(-7.9763 - 0.1949 * a + 0.0008 * k) - np.exp(2.1016 + 0.0843 * a - 0.0176 * k) + 1.792
        moments[hip] += table.scale * at_hip
        moments[knee] += table.scale * at_knee
        moments[ankle] += table.scale * at_ankle


@compiled
def add_passive_slopes(table: PassiveTable, angles: Vector, slopes: Matrix) -> None:
    """Add the derivatives of the passive moments (row) by the joint angles (column) to slopes (39, 39) N.m/rad."""
    for i in range(len(angles)):
        if table.at_lower_nm[i] > 0 or table.at_upper_nm[i] > 0:
            below = table.at_lower_nm[i] * np.exp(-table.per_rad[i] * (angles[i] - table.lower[i]))
            above = table.at_upper_nm[i] * np.exp(table.per_rad[i] * (angles[i] - table.upper[i]))
            slopes[i, i] -= table.scale * table.per_rad[i] * (below + above)
    per_degree = DEGREE * table.scale
    for leg in range(len(table.legs)):
        hip, knee, ankle = table.legs[leg]
        h, k, a = DEGREE * angles[hip], DEGREE * angles[knee], DEGREE * angles[ankle]
        extended, flexed = np.exp(1.4655 - 0.0034 * k - 0.0750 * h), np.exp(1.3403 - 0.0226 * k + 0.0305 * h)
        slopes[hip, hip] += per_degree * (-0.0750 * extended - 0.0305 * flexed)
        slopes[hip, knee] += per_degree * (-0.0034 * extended + 0.0226 * flexed)
        straight = np.exp(1.800 + 0.0460 * a - 0.0352 * k + 0.0217 * h)
        bent, stopped = np.exp(-3.971 + 0.0004 * a + 0.0495 * k - 0.0128 * h), np.exp(2.220 - 1.50 * k)
        slopes[knee, ankle] += per_degree * (0.0460 * straight - 0.0004 * bent)
        slopes[knee, knee] += per_degree * (-0.0352 * straight - 0.0495 * bent - 1.50 * stopped)
        slopes[knee, hip] += per_degree * (0.0217 * straight + 0.0128 * bent)
        pointed, raised = np.exp(-7.9763 - 0.1949 * a + 0.0008 * k), np.exp(2.1016 + 0.0843 * a - 0.0176 * k)
        slopes[ankle, ankle] += per_degree * (-0.1949 * pointed - 0.0843 * raised)
        slopes[ankle, knee] += per_degree * (0.0008 * pointed + 0.0176 * raised)
