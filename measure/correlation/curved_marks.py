"""Where a mark seems to be when it is not flat: what a refinement with a plain warp makes of a motion that is not one.

A mark on a cylinder that turns bends in the picture. The refined warp then is that least-squares fit to the bent motion
in which every pixel counts by its texture, so two marks at the same place with other speckles come out differently (by
0.05 px on a subset of 25 px turning by 30 deg about a radius of 140 px). The texture is known, and so is the difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from measure.correlation.reference_image import Reference

Array = NDArray[np.float64]

_ALONG = np.array([-1.0, 0.0, 1.0]) * np.sqrt(0.6)
NODES = np.stack(np.meshgrid(_ALONG, _ALONG), axis=-1).reshape(9, 2)
"""Gauss-Legendre points of the square from -1 to 1: motions up to the second order along each side are met exactly."""

SHARES = np.outer([5.0, 8.0, 5.0], [5.0, 8.0, 5.0]).ravel() / 324.0
EVEN = SHARES[:, None, None] * np.eye(2)
"""The response of a texture that is the same everywhere."""

_SHIFT, _TURN = 2, 3


@dataclass(frozen=True)
class Response:
    """How the marks' refined places follow from where their nodes are.

    reference_px : (marks, 2), the reference points. nodes_px : (marks, 9, 2), the subsets' nodes in the reference image.
    weights : (marks, 9, 2, 2). parameters : (marks,), of the warp: 2, 3 or 6.
    """

    reference_px: Array
    nodes_px: Array
    weights: Array
    parameters: NDArray[np.int64]

    def only(self, kept: NDArray[np.bool_]) -> Response:
        """The same without some of the marks; kept : (marks,)."""
        return Response(self.reference_px[kept], self.nodes_px[kept], self.weights[kept], self.parameters[kept])

    def apparent(self, at_px: Array) -> Array:
        """Where the refinement puts the reference points when the nodes are at `at_px`, (..., marks, 9, 2). Returns (..., marks, 2).

            place = A (p + sum_q W_q (A^-1 x_q - n_q))

        with A the warp's own matrix (the least-squares one; its rotation where the warp can only turn, one where it can only
        shift), n and x the nodes before and after, p the reference point, W the weights.
        """
        matrix = self._matrix(at_px)
        bent = np.einsum("...nij,...nqj->...nqi", np.linalg.inv(matrix), at_px) - self.nodes_px
        place = self.reference_px + np.einsum("nqij,...nqj->...ni", self.weights, bent)
        return np.einsum("...nij,...nj->...ni", matrix, place)

    def _matrix(self, at_px: Array) -> Array:
        lever = self.nodes_px - np.einsum("q,nqj->nj", SHARES, self.nodes_px)[:, None]
        square = np.einsum("q,nqj->n", SHARES, lever**2) / 2.0
        full = np.einsum("q,...nqi,nqj->...nij", SHARES, at_px, lever) / square[:, None, None]
        angle = np.arctan2(full[..., 1, 0] - full[..., 0, 1], full[..., 0, 0] + full[..., 1, 1])
        turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=-1).reshape(full.shape)
        kind = self.parameters[:, None, None]
        return np.where(kind == _SHIFT, np.eye(2), np.where(kind == _TURN, turn, full))


def responses(marks: list[Reference]) -> Response:
    """The response of prepared marks, each by its own texture."""
    centres = np.array([[mark.column, mark.row] for mark in marks], float)
    halves = np.array([mark.half + 0.5 for mark in marks])
    nodes = centres[:, None] + halves[:, None, None] * NODES
    points = centres + np.array([mark.offset for mark in marks])
    return Response(points, nodes, np.array([_weights(mark) for mark in marks]), np.array([mark.warp for mark in marks]))


def _weights(mark: Reference) -> Array:
    """(9, 2, 2): shift of the reference point for a motion of one node by one pixel along each axis.

    The motion between the nodes is their polynomial l_q; Gauss-Newton's answer to it is H^-1 S' (l_q grad f).
    """
    across = np.arange(-mark.half, mark.half + 1) / (mark.half + 0.5)
    along = np.array([np.prod([(across - b) / (a - b) for b in _ALONG if b != a], axis=0) for a in _ALONG])
    bumps = np.einsum("ai,bj->abij", along, along).reshape(9, -1)[:, mark.kept]
    answer = mark.point_slopes @ mark.inverse_hessian @ mark.free.astype(float)
    return np.einsum("ki,qi,ci->qkc", answer, bumps, mark.descent[:2].astype(float))
