# SPDX-License-Identifier: GPL-3.0-or-later
"""Coats whose bakes over live values several tests look at: one is made for all of a half of the suite."""

VARNISH = {"kind": "dielectric", "roughness": 0.35, "tint": [0.9, 0.7, 0.4], "thickness": 0.7}
TWO_COATS = [{"kind": "dielectric", "roughness": 0.2}, VARNISH]
GLAZE = {"kind": "dielectric", "tint": [0.6, 0.7, 0.9]}
MILK = {"kind": "dielectric", "roughness": 0.55, "scatter_color": [0.8, 0.6, 0.3], "density": 1.0, "scatter_g": 0.4}
WOOD = {"kind": "lambert", "color": [0.7, 0.45, 0.25]}
CLAY = {"kind": "oren_nayar", "color": [0.7, 0.45, 0.25], "sigma_deg": 30.0}
METAL = {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [0.9, 0.8, 0.7], "roughness": 0.4}
