# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks of many masks."""

PAINTS = [{"kind": "oren_nayar", "color": [0.1 * i + 0.05, 0.9 - 0.1 * i, 0.3], "sigma_deg": 5.0 * i + 5.0, "coverage": 0.3} for i in range(8)]
_COATS = [{"kind": "dielectric", "ior": ior, "roughness": roughness, "coverage": 0.5} for ior, roughness in ((1.5, 0.3), (1.8, 0.6), (1.3, 0.5))]
PAINTS_BELOW_COATS = [*_COATS, PAINTS[1], PAINTS[5]]
