"""Where all bodies are at many configurations at once: forward kinematics of the skeleton, compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.skeleton import BODIES, JOINTS

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]


class Tree(NamedTuple):
    """The 16 compound joints of a worker: the bodies they connect, their centres in the parent's frame (16, 3) m, and
    axis (39,) and sign (39,) of each degree of freedom; joint k has those from first[k] to first[k + 1].
    """

    parent: Indices
    child: Indices
    centre_m: Vector
    first: Indices
    axis: Indices
    sign: Vector


class Poses(NamedTuple):
    """Orientations (n, 17, 3, 3) and origins (n, 17, 3) m of the bodies in the world, in the order of `BODIES`."""

    rotation: Vector
    origin_m: Vector

    def points(self, body: str, local_m: Vector) -> Vector:
        """A point (3,) m of a body's frame in the world, (n, 3) m."""
        index = BODIES.index(body)
        return np.asarray(self.origin_m[:, index] + self.rotation[:, index] @ local_m)


def tree_of(person: Anthropometry) -> Tree:
    """The joints of a worker."""
    axes = [dof.axis for joint in JOINTS for dof in joint.degrees_of_freedom]
    return Tree(
        parent=np.array([BODIES.index(joint.parent) for joint in JOINTS]),
        child=np.array([BODIES.index(joint.child) for joint in JOINTS]),
        centre_m=np.array([person.joint_centre(joint.name) for joint in JOINTS]),
        first=np.cumsum([0, *(len(joint.degrees_of_freedom) for joint in JOINTS)]),
        axis=np.array(["xyz".index(axis[1]) for axis in axes]),
        sign=np.array([float(axis[0] + "1") for axis in axes]),
    )


def poses_of(tree: Tree, configuration: Vector) -> Poses:
    """The poses of all bodies at configurations (n, 46), as in `Human`."""
    return Poses(*poses(tree, np.ascontiguousarray(configuration)))


@compiled
def poses(tree: Tree, configuration: Vector) -> tuple[Vector, Vector]:
    """The arrays of `Poses`, for compiled functions."""
    count, bodies = configuration.shape[0], tree.child.size + 1
    rotation, origin = np.empty((count, bodies, 3, 3)), np.empty((count, bodies, 3))
    for row in range(count):
        origin[row, 0] = configuration[row, :3]
        x, y, z, w = configuration[row, 3:7]
        rotation[row, 0, 0] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
        rotation[row, 0, 1] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
        rotation[row, 0, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
        for joint in range(tree.child.size):
            parent, child = tree.parent[joint], tree.child[joint]
            for i in range(3):
                origin[row, child, i] = origin[row, parent, i]
                for j in range(3):
                    origin[row, child, i] += rotation[row, parent, i, j] * tree.centre_m[joint, j]
                    rotation[row, child, i, j] = rotation[row, parent, i, j]
            for dof in range(tree.first[joint], tree.first[joint + 1]):
                angle = tree.sign[dof] * configuration[row, 7 + dof]
                cosine, sine = np.cos(angle), np.sin(angle)
                # turning about an axis mixes the columns of the two axes after it
                one, two = (tree.axis[dof] + 1) % 3, (tree.axis[dof] + 2) % 3
                for i in range(3):
                    a, b = rotation[row, child, i, one], rotation[row, child, i, two]
                    rotation[row, child, i, one] = cosine * a + sine * b
                    rotation[row, child, i, two] = cosine * b - sine * a
    return rotation, origin
