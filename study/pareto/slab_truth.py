# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of explicit slab geometry, measured: where Cycles' paths leave to, against the walks of `position_free`."""

import numpy as np

from ...addon.blender.versions import node_tree
from ...reference_py.material.stack import Stack
from ...reference_py.optics.error_measure import albedo_error, worst_share
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model
from .bench import Stage, look_along
from .reflectance import THETA_DEG, Errors

# No view has its mirror direction on an edge, in either angle.
_THETA_EDGES = np.radians([0.0, *np.arange(2.5, 90.0, 6.0), 90.0])
_AZIMUTHS = 16
_WALKS = 200_000
# Added to a direction to tell it apart from darkness.
_OFFSET = 2.0


def slab_errors(stage: Stage, sample, stack: Stack, truth, renders: int) -> Errors:
    """Errors of a sample on a furnace stage; `renders` pictures of one path a pixel for each view. Histograms see a shape coarsely."""
    phi_edges = (np.arange(_AZIMUTHS + 1) - 0.5) * 2.0 * np.pi / _AZIMUTHS
    walker = make_model("position_free", stack, walks=_WALKS)
    stage.show(sample)
    albedo, shape = [], []
    for theta in THETA_DEG:
        look_along(stage, theta)
        wi, energy = _paths(stage, renders)
        wo = spherical(np.radians(theta), 0.0)
        exact = truth.albedo(wo[None])[0]
        rows = np.clip(np.searchsorted(_THETA_EDGES, np.arccos(np.clip(wi[:, 2], -1.0, 1.0))) - 1, 0, len(_THETA_EDGES) - 2)
        columns = np.round(np.arctan2(wi[:, 1], wi[:, 0]) / (2.0 * np.pi) * _AZIMUTHS).astype(int) % _AZIMUTHS
        measured = np.zeros((len(_THETA_EDGES) - 1, _AZIMUTHS, 3))
        np.add.at(measured, (rows, columns), energy)
        measured /= renders * stage.size**2
        expected = walker.histogram(wo, _THETA_EDGES, phi_edges).energy
        gap = 0.5 * np.abs(_folded(measured) - _folded(expected)).sum(axis=(0, 1))
        albedo.append(albedo_error(measured.sum(axis=(0, 1)), exact))
        shape.append(worst_share(gap, exact))
    return Errors(float(np.max(albedo)), float(np.max(shape)), float(np.mean(shape)))


def _folded(histogram: np.ndarray) -> np.ndarray:
    """Both sides of the plane of incidence are the same, and around the normal all azimuths."""
    histogram = histogram.copy()
    histogram[0] = histogram[0].mean(axis=0)
    return histogram + histogram[:, -np.arange(_AZIMUTHS) % _AZIMUTHS]


def _paths(stage: Stage, renders: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) that paths left to and what they carried (n, 3).

    Of two pictures with the same random numbers one is under a white world, the other under one whose color is the
    direction; their ratio is where the path went.
    """
    wi, energy = [], []
    for seed in range(renders):
        pictures = []
        for directional in (False, True):
            _world(stage, directional)
            pictures.append(stage.picture(1, seed).reshape(-1, 3))
        white, coded = pictures
        seen = np.all(white > 1e-6, axis=-1)
        wi.append(coded[seen] / white[seen] - _OFFSET)
        energy.append(white[seen])
    return np.concatenate(wi), np.concatenate(energy)


def _world(stage: Stage, directional: bool) -> None:
    tree = node_tree(stage.scene.world)
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    if directional:
        place, offset = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
        offset.inputs[1].default_value = (_OFFSET,) * 3
        tree.links.new(place.outputs["Generated"], offset.inputs[0])
        tree.links.new(offset.outputs[0], background.inputs["Color"])
