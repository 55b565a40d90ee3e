"""The error of the reference image: one offset for each mark that all later frames share, estimated with the poses of all frames.

Pixels with gaps between them, an edge along a row of pixels, or compression put a mark beside its place in the reference image.
Every later sighting is off by that, as the body carries it, so that more frames do not average it out:

    seen_ti = projected_i(pose_t) + s_ti A_ti e_i + noise_ti,    e_i ~ N(0, c D_i)

A is what the motion makes of a small shift on the mark. While a mark is still where it was, both images err alike and s is zero. D is
the variance that the marks' own scatter gives it, c a factor near one that the film decides. Offsets that look like a pose stay
unknown: their variance is part of the covariance. The derivation is in docs/theory/image-correlation.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import Marks
from measure.geometry.body import Body
from measure.geometry.camera import Camera
from measure.geometry.own_noise import own_noise
from measure.geometry.rigid_body import Fit, fit_platform, weights_of

Array = NDArray[np.float64]

_LEFT_PX = 0.25
"""Motion, px, by which a mark has left the place at which its error was that of the reference image: well below a pixel,
because the errors of pixels repeat with each of them."""

_GONE = 0.9
"""Share of the error from which a mark has left its first place."""

_LOG_FACTORS = np.linspace(-3.0, 3.0, 61)
"""Logarithms of c that are tried; its prior is normal with a standard deviation of one."""


def without_reference_error(marks: Marks, camera: Camera, points: Array, fit: Fit) -> tuple[Marks, Fit]:
    """The marks with their own scatter from frame to frame and without their errors in the reference image, and the body fitted to them.

    Parameters
    ----------
    marks, camera, points
        As in `fit_platform`.
    fit : Fit
        Of the body to these marks.

    Returns
    -------
    marks : Marks
        The same where their scatter is no larger than their standard deviations.
    fit : Fit
    """
    noise = own_noise(marks, fit, have_left(marks))
    if noise is None:
        return marks, fit
    first, marks = marks, noise.on(marks)
    fit = fit_platform(marks, camera, points, fit.free, fit.pose)
    error = reference_error(marks, fit, Body(camera, points, marks.response), noise.reference_px2)
    marks = noise.slow(error.kept).on(error.taken_off(first))
    fit = fit_platform(marks, camera, points, fit.free, fit.pose)
    return error.on_marks(marks), error.on_fit(fit, marks)


def share_left(marks: Marks) -> Array:
    """How far marks are free of the error that they have at their first place.

    Parameters
    ----------
    marks : Marks

    Returns
    -------
    (frames, marks) array
        From zero to one, zero where a mark is not seen.
    """
    place = np.stack([marks.x_px, marks.y_px], axis=-1)
    moved = np.linalg.norm(place - marks.reference_px, axis=-1)
    return np.nan_to_num(-np.expm1(-0.5 * (moved / _LEFT_PX) ** 2))


def have_left(marks: Marks) -> NDArray[np.bool_]:
    """Frames in which a mark has left its first place, (frames,)."""
    return np.any(share_left(marks) > _GONE, axis=1)


@dataclass(frozen=True)
class ReferenceError:
    """The offsets of n marks in t frames.

    Attributes
    ----------
    carried : (t, n, 2, 2) array
        s A, what a mark's offset adds to its position.
    offset_px : (n, 2) array
        In the reference image.
    covariance_px2 : (2n, 2n) array
        Of the offsets.
    kept : float
        Share of their expected variance that is not in the reference image.
    """

    carried: Array
    offset_px: Array
    covariance_px2: Array
    kept: float

    def taken_off(self, marks: Marks) -> Marks:
        """The marks without the offsets; their covariances are as they were."""
        shift = np.einsum("tnij,nj->tni", self.carried, self.offset_px)
        return replace(marks, x_px=marks.x_px - shift[..., 0], y_px=marks.y_px - shift[..., 1])

    def on_marks(self, marks: Marks) -> Marks:
        """The marks with the variance of the offsets in their covariances."""
        count = len(self.offset_px)
        own = np.einsum("ninj->nij", self.covariance_px2.reshape(count, 2, count, 2))
        return replace(marks, covariance_px2=marks.covariance_px2 + np.einsum("tnij,njl,tnml->tnim", self.carried, own, self.carried))

    def on_fit(self, fit: Fit, marks: Marks) -> Fit:
        """The fit to these marks with the variance of the offsets in its covariance."""
        frames = _linearised(fit, marks, self.carried)
        by = frames.covariance @ np.swapaxes(frames.seen, 1, 2)
        added = by @ self.covariance_px2 @ np.swapaxes(by, 1, 2) * fit.widened[:, None, None] ** 2
        return replace(fit, covariance=fit.covariance + np.where(fit.has_pose[:, None, None], added, 0.0))


@dataclass(frozen=True)
class _Linearised:
    """Sightings of n marks in t frames about the poses that fit best. weight : (t, n, 2, 2), zero for what took no part in the fit.
    residual : (t, n, 2), px. carried : (t, n, 2, 2). covariance : (t, k, k), of the poses by the weights alone. seen : (t, 2n, k),
    (s A)' W J, what the pose sees of the offsets."""

    weight: Array
    residual: Array
    carried: Array
    covariance: Array
    seen: Array


def _linearised(fit: Fit, marks: Marks, carried: Array) -> _Linearised:
    used = fit.used & fit.has_pose[:, None]
    weight, slopes = np.where(used[..., None, None], weights_of(marks), 0.0), np.where(used[..., None, None], fit.slopes, 0.0)
    normal = np.einsum("tnik,tnij,tnjl->tkl", slopes, weight, slopes)
    normal[~fit.has_pose] = np.eye(normal.shape[1])
    seen = np.einsum("tnji,tnjl,tnlk->tnik", carried, weight, slopes).reshape(len(weight), -1, normal.shape[1])
    return _Linearised(weight, np.where(used[..., None], fit.residual_px, 0.0), carried, np.linalg.inv(normal), seen)


def reference_error(marks: Marks, fit: Fit, body: Body, variance_px2: Array) -> ReferenceError:
    """The offsets that all frames of a film share.

    Parameters
    ----------
    marks : Marks
    fit : Fit
        Of the body to these marks.
    body : Body
    variance_px2 : (marks, 2) array
        D, what the marks' own scatter gives to the variance of their offsets.

    Returns
    -------
    ReferenceError
    """
    pose = np.where(fit.has_pose[:, None], fit.pose, 0.0)
    carried = body.carried(pose) * share_left(marks)[..., None, None]
    counted = _independent(marks) / fit.widened**2  # where the geometry is wrong, the misfit is not of the reference image
    matrix, vector = _equations(_linearised(fit, marks, carried), counted)
    offset, covariance, factor = _offsets(matrix, vector, variance_px2.ravel())
    return ReferenceError(carried, offset.reshape(-1, 2), covariance, max(0.0, 1.0 - factor))


def _offsets(matrix: Array, vector: Array, variance: Array) -> tuple[Array, Array, float]:
    """The offsets (2n,), their covariance, and the mean of c, from normal equations and the variances D; c is integrated out.

    In units of sqrt(D) and along the eigenvectors of the equations, which are the same for all c, with eigenvalues l and right-hand
    sides b: the offsets are c b / (1 + c l), their variances c / (1 + c l), and log L(c) is the sum of
    c b^2 / (2 + 2 c l) - log(1 + c l) / 2.
    """
    root, c = np.sqrt(variance), np.exp(_LOG_FACTORS)[:, None]
    values, vectors = np.linalg.eigh(root[:, None] * matrix * root)
    values, along = np.maximum(values, 0.0), vectors.T @ (root * vector)
    known = c / (1.0 + c * values)
    likely = np.sum(0.5 * along**2 * known - 0.5 * np.log1p(c * values), axis=1) - 0.5 * _LOG_FACTORS**2
    share = np.exp(likely - likely.max())
    share /= share.sum()
    each, back = known * along, root[:, None] * vectors
    mean = share @ each
    spread = np.diag(share @ known) + (share * (each - mean).T) @ (each - mean)
    return back @ mean, back @ spread @ back.T, float(share @ c[:, 0])


def _equations(frames: _Linearised, counted: Array) -> tuple[Array, Array]:
    """Normal equations of the offsets with the poses eliminated, (2n, 2n) and (2n,); counted : (t,), as how much each frame counts."""
    own = np.einsum("t,tnji,tnjl,tnlm->nim", counted, frames.carried, frames.weight, frames.carried)
    matrix = -np.einsum("t,tak,tkl,tbl->ab", counted, frames.seen, frames.covariance, frames.seen, optimize=True)
    for i, block in enumerate(own):
        matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += block
    return matrix, np.einsum("t,tnji,tnjl,tnl->ni", counted, frames.carried, frames.weight, frames.residual).ravel()


def _independent(marks: Marks) -> Array:
    """As how many independent frames each one counts, (frames,): the errors of a mark are one draw while it is at the same place."""
    share = np.empty(marks.x_px.shape)
    for i in range(len(marks.names)):
        cells = np.nan_to_num(np.floor(np.stack([marks.x_px[:, i], marks.y_px[:, i]], axis=-1) / _LEFT_PX))
        _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
        share[:, i] = 1.0 / count[which.ravel()]
    return share.mean(axis=1)
