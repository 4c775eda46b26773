# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants of the tier `analytic`, found by search against the albedos of `models.adding`.

The stacks were the suite, the presets and eighty random ones of one to three layers; error bounds are in the tests.
"""

# --- how a rough interface changes a refracted beam (beam.py) ---
LEAN_GGX = (2.541, 3.164, 4.435)
LEAN_BECKMANN = (0.93, 1.815, 0.448)
"""How far the facets that a beam sees lean towards it, in alphas: a t / (1 + b alpha + c t), t = alpha tan(theta)."""
LOBE_SPREAD = 1.443
"""Variance of slope in the spread of p, in alpha^2."""
SPREAD_GRAZING = 0.287
"""Facets seen at grazing angles spread less: 1 / (1 + this t)."""
MOST_SHARE = 0.91
"""Limit of p over n behind a rough interface."""
LEAST_COS2 = 1e-6

# --- reflectance of an interface for a widened beam ---
SPREAD_INCIDENCE = 1.826
"""Spread of the angle of incidence, per variance of p."""
SPREAD_HALF = 0.291
"""Spread at which a quarter of a beam is met as uniform light."""
SPREAD_LIMIT = 0.247
"""Limit of the spread that counts as roughness."""

# --- light that goes back up between interfaces ---
BACK_SPREAD = 0.507
TRAPPED_COS = 0.782
"""Cosine of totally reflected light over that of the critical angle."""
TRAPPED_SPREAD = 0.524

# --- absorption of a widened beam ---
TAU_SPREAD = 0.937
TAU_SHARE = 0.974

# --- the lobe of a metal base (base.py) ---
EXIT_SPREAD = 0.732
NODE_SPREAD = 0.218
"""Width of one direction of the lobe over that of the lobe."""
MOST_LOBE_SHARE = 0.871
"""Limit of p over n of the lobe's directions."""
STIR_SCALE = 0.087
"""Lobe alpha at which half of the later orders is uniform light."""
KEPT_ORDER, KEPT_SCALE = 0.851, 0.01
"""Rough layers turn trapped light to grazing angles: what escapes again is less by this share, half of it at this alpha."""
BASE_LOSS = 0.786
"""1 / (1 + this alpha^2 / (1 + alpha)) is about the mean energy of one reflection on a rough metal."""
LEAST_COS = 1e-3

# --- lobes outside (network.py) ---
LOBE_BEND = 0.8
