"""What the refinement makes of a motion that the warp cannot follow: systematic errors of undermatched shape functions.

A mark on a cylinder that turns bends in the picture. The refined affine warp is the least-squares fit to the bent motion
in which every pixel counts by its texture, so two marks at the same place with different speckles come out differently
(by 0.05 px on a subset of 25 px turning by 30 deg about a radius of 140 px). The texture is known, and so is the
difference: it is computed here and is part of the model of the platform, not an error.

Schreier and Sutton, Systematic errors in digital image correlation due to undermatched subset shape functions,
Experimental Mechanics 42 (2002) 303.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    """How the marks' refined positions follow from the positions of nine nodes in each subset.

    Attributes
    ----------
    reference_px : (marks, 2) array
        Reference points in the reference image, px.
    nodes_px : (marks, 9, 2) array
        Nodes of the subsets in the reference image, px.
    weights : (marks, 9, 2, 2) array
        Shift of the reference point for a shift of each node.
    parameters : (marks,) array of int
        Number of parameters of each mark's warp: 2 (shift), 3 (shift and rotation) or 6 (affine).
    followed : (marks, 4, 4) array
        What each affine warp takes of a change of its matrix, row by row; a texture may not determine all of it.
    """

    reference_px: Array
    nodes_px: Array
    weights: Array
    parameters: NDArray[np.int64]
    followed: Array

    def only(self, kept: NDArray[np.bool_]) -> Response:
        """The same for some of the marks; kept : (marks,) array of bool."""
        return Response(self.reference_px[kept], self.nodes_px[kept], self.weights[kept], self.parameters[kept], self.followed[kept])

    def apparent(self, at_px: Array) -> Array:
        """Where the refinement puts the reference points.

            p' = A (p + sum_q W_q (A^-1 x_q - n_q))

        with A the matrix of the warp (the least-squares one, as far as the texture determines it; its rotation where the
        warp can only shift and rotate, one where it can only shift), n and x the nodes before and after, p the reference
        point, W the weights.

        Parameters
        ----------
        at_px : (..., marks, 9, 2) array
            Nodes in the current image, px.

        Returns
        -------
        (..., marks, 2) array
            px.
        """
        matrix = self._matrix(at_px)
        bent = np.einsum("...nij,...nqj->...nqi", np.linalg.inv(matrix), at_px) - self.nodes_px
        place = self.reference_px + np.einsum("nqij,...nqj->...ni", self.weights, bent)
        return np.einsum("...nij,...nj->...ni", matrix, place)

    def stretch(self, at_px: Array) -> Array:
        """The matrix of the affine motion that fits the nodes best, (..., marks, 2, 2); at_px as in `apparent`."""
        lever = self.nodes_px - np.einsum("q,nqj->nj", SHARES, self.nodes_px)[:, None]
        square = np.einsum("q,nqj->n", SHARES, lever**2) / 2.0
        return np.asarray(np.einsum("q,...nqi,nqj->...nij", SHARES, at_px, lever) / square[:, None, None])

    def _matrix(self, at_px: Array) -> Array:
        affine = self.stretch(at_px)
        angle = np.arctan2(affine[..., 1, 0] - affine[..., 0, 1], affine[..., 0, 0] + affine[..., 1, 1])
        turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=-1).reshape(affine.shape)
        change = (affine - np.eye(2)).reshape(*affine.shape[:-2], 4)
        affine = np.eye(2) + np.einsum("nij,...nj->...ni", self.followed, change).reshape(affine.shape)
        kind = self.parameters[:, None, None]
        return np.where(kind == _SHIFT, np.eye(2), np.where(kind == _TURN, turn, affine))


def node_weights(half: int, kept: NDArray[np.int64], descent: NDArray, answer: Array) -> Array:
    """Shift of a mark's reference point for a motion of one node by one pixel along each axis.

    The motion between the nodes is their Lagrange polynomial l_q; the answer of Gauss-Newton to it is H^-1 S' (l_q grad f).

    Parameters
    ----------
    half : int
        The subset is 2 half + 1 px wide.
    kept : (n,) array of int
        Pixels of the square that belong to the mark.
    descent : (k, n) array
        Steepest-descent images; the first two are the slopes of the reference image along x and y.
    answer : (2, n) array
        Shift of the reference point for one grey level more in each pixel, from `Reference.answer`.

    Returns
    -------
    (9, 2, 2) array
    """
    across = np.arange(-half, half + 1) / (half + 0.5)
    along = np.array([np.prod([(across - b) / (a - b) for b in _ALONG if b != a], axis=0) for a in _ALONG])
    bumps = np.einsum("ai,bj->abij", along, along).reshape(9, -1)[:, kept]
    return np.einsum("ki,qi,ci->qkc", answer, bumps, descent[:2].astype(float))
