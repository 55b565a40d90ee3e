"""How well six legs hold the platform: the condition number of their lines, and the poses in which they lose a direction.

Row i of J is what moves leg i, l_i' = J_i v, with the arms over their root mean square length so that all entries are pure numbers:

    J_i = [e_i, (r_i x e_i) / L]        condition = |J| |J^-1| / 6, Frobenius norms

It is 1 where all directions are held alike, and infinite in a singular pose, where the legs hold one direction not at all and a small
force along it moves the platform freely. Source: Gosselin and Angeles 1991, doi:10.1109/70.88119 (condition number of a robot's Jacobian);
Fichter 1986, doi:10.1177/027836498600500216 (a symmetric platform is singular when it is turned by 90 degrees).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.kernel.layout import LEGS, SAMPLE_POSE
from simulate.model.model import Model
from simulate.model.rig import Geometry, geometry_of

_TURNS_DEG = np.arange(0.0, 181.0, 2.0)
_CLOSE = 1e-9  # of the largest determinant: a pose that is singular


def legs_jacobian(geometry: Geometry, place: Array, rotation: Array) -> Array:
    """(n, 6, 6) J of poses, arms over their root mean square length.

    Parameters
    ----------
    place : (n, 3) m, origin of the platform frame. rotation : (n, 3, 3), platform axes to world axes.
    """
    joints = np.asarray(geometry.platform_joints_m)
    arms = np.einsum("nij,lj->nli", rotation, joints)
    legs = place[:, None, :] + arms - np.asarray(geometry.base_joints_m)
    axes = legs / np.linalg.norm(legs, axis=2, keepdims=True)
    return np.concatenate([axes, np.cross(arms, axes) / rms_arm(geometry)], axis=2)


def rms_arm(geometry: Geometry) -> float:
    """Root mean square distance of the platform joints from the origin of the platform frame, m."""
    return float(np.sqrt(np.mean(np.sum(np.asarray(geometry.platform_joints_m) ** 2, axis=1))))


def condition_of(jacobian: Array) -> Array:
    """(n,) condition numbers, infinite where a pose is singular."""
    found = np.full(len(jacobian), np.inf)
    size = np.linalg.norm(jacobian, axis=(1, 2))
    good = np.abs(np.linalg.det(jacobian)) > 1e-300
    found[good] = size[good] * np.linalg.norm(np.linalg.inv(jacobian[good]), axis=(1, 2)) / LEGS
    return found


def condition_along(model: Model, samples: Array) -> Array:
    """(n,) condition of the legs in the poses of a deployment's samples (n, SAMPLE_SIZE ...), NaN where it has diverged."""
    found = np.full(len(samples), np.nan)
    good = np.isfinite(samples[:, SAMPLE_POSE : SAMPLE_POSE + 7]).all(axis=1)
    place, quaternion = samples[good, SAMPLE_POSE : SAMPLE_POSE + 3], samples[good, SAMPLE_POSE + 3 : SAMPLE_POSE + 7]
    found[good] = condition_of(legs_jacobian(geometry_of(model.adjusted()), place, _rotations(quaternion)))
    return found


def singular_theta_z_deg(geometry: Geometry, height_m: float) -> tuple[float | None, float | None]:
    """Rotations about the vertical, the nearest to either side, in which the legs lose a direction at a height; None where there is none.

    The platform is centred and level; between 0 and half a turn the determinant of J is looked at every 2 degrees and its first change of
    sign is found to the last digits.
    """
    return _nearest(geometry, height_m, -1.0), _nearest(geometry, height_m, 1.0)


def condition_report(model: Model, time_s: Array, samples: Array) -> dict[str, Any]:
    """What the JSON of a deployment says of it: at the release, at its largest and when, and the singular rotations at both heights."""
    along, geometry = condition_along(model, samples), geometry_of(model)
    known = np.flatnonzero(~np.isnan(along))
    worst = int(known[np.argmax(along[known])]) if len(known) else None
    return {
        "at_release": _number(along[0]),
        "largest": None if worst is None else _number(along[worst]),
        "largest_at_s": None if worst is None else float(time_s[worst]),
        "singular_theta_z_deg": {
            "stowed": singular_theta_z_deg(geometry, geometry.stowed_height_m),
            "deployed": singular_theta_z_deg(geometry, geometry.deployed_height_m),
        },
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _nearest(geometry: Geometry, height_m: float, side: float) -> float | None:
    from scipy.optimize import brentq

    def volume(turn_deg: float) -> float:
        return float(_volumes(geometry, height_m, np.array([side * turn_deg]))[0])

    found = _volumes(geometry, height_m, side * _TURNS_DEG)
    if abs(found[0]) <= _CLOSE * np.max(np.abs(found)):
        return 0.0
    changes = np.flatnonzero(found[:-1] * found[1:] <= 0.0)
    if not len(changes):
        return None
    before, behind = _TURNS_DEG[changes[0]], _TURNS_DEG[changes[0] + 1]
    return side * float(brentq(volume, before, behind, xtol=1e-9))  # type: ignore[arg-type]


def _volumes(geometry: Geometry, height_m: float, turns_deg: Array) -> Array:
    """Determinant of J over rotations about the vertical."""
    half = np.radians(turns_deg) / 2
    quaternion = np.stack([np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)], axis=1)
    place = np.tile([0.0, 0.0, height_m], (len(half), 1))
    return np.linalg.det(legs_jacobian(geometry, place, _rotations(quaternion)))


def _rotations(quaternion: Array) -> Array:
    """(n, 3, 3) rotation matrices of unit quaternions (n, 4), scalar first."""
    w, x, y, z = quaternion.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
