# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants of the method `analytic`, fitted to the albedos of `models.adding`; `study/calibrate_analytic.py` fits them again.

Levenberg-Marquardt steps in the logarithms of the constants (logits where they have an upper limit), on the signed relative
errors in per cent of every channel, squared in size so that large ones count, at 0, 40, 65 and 80 degrees. Stacks: the suite and
the presets (weight 1), and 51 random ones of one or two layers (weight 1/4; index 1.2 to 2.1, alpha 0 to .8, two in five
tinted, three in five over metals). Albedo error, worst view and channel: fitted suite and presets, median 1.7 %, worst 8.9 %;
fitted random ones 4.1 and 11 %; 38 random ones that were not fitted 4.1 and 11 %; 22 of three to six strongly tinted rough
layers that were not fitted 12 and 36 %.
"""

# --- how a rough interface changes a refracted beam (beam.py) ---
LEAN_GGX = (3.254, 2.72, 8.565)
LEAN_BECKMANN = (0.8391, 5.463, 0.09748)
"""How far the facets that a beam sees lean towards it, in alphas: a t / (1 + b alpha + c t), t = alpha tan(theta)."""
LOBE_SPREAD = 1.619
"""Variance of slope in the spread of p, in alpha^2."""
SPREAD_GRAZING = 0.2053
"""Facets seen at grazing angles spread less: 1 / (1 + this t)."""
MOST_SHARE = 0.9349
"""Limit of p over n behind a rough interface."""
LEAST_COS2 = 1e-6

# --- reflectance of an interface for a widened beam ---
SPREAD_INCIDENCE = 4.827
"""Spread of the angle of incidence, per variance of p."""
SPREAD_HALF = 0.9431
"""Spread at which a quarter of a beam is met as uniform light."""
SPREAD_LIMIT = 0.08836
"""Limit of the spread that counts as roughness."""

# --- light that goes back up between interfaces ---
BACK_SPREAD = 2.528
TRAPPED_COS = 0.713
"""Cosine of totally reflected light over that of the critical angle."""
TRAPPED_SPREAD = 0.4318

# --- absorption of a widened beam ---
TAU_SPREAD = 1.308
TAU_SHARE = 0.9447

# --- the lobe of a metal base (base.py) ---
EXIT_SPREAD = 0.5115
NODE_SPREAD = 0.5432
"""Width of one direction of the lobe over the range of slopes that it stands for."""
MOST_LOBE_SHARE = 0.9297
"""Limit of p over n of the lobe's directions."""
REMIX_SCALE, REMIX_BACK, REMIX_POWER = 0.1237, 0.1057, 0.7752
"""Later orders are uniform light by x / (x + scale), x = lobe alpha^power: what escapes, and what returns."""
RETAINED_ORDER, RETAINED_SCALE = 0.713, 0.003982
"""Rough layers turn trapped light to grazing angles: what escapes again is less by this share, half of it at this alpha."""
BASE_LOSS = 0.1336
"""1 / (1 + this alpha^2 / (1 + alpha)) is about the mean energy of one reflection on a rough metal."""
LEAST_COS = 1e-3
ANISOTROPIC_RETAINED = 0.7
"""Of light that an anisotropic metal's first facet does not let go, its share, this often, is the share that later ones keep. Fitted to
`position_free`: metals of .9, .6 and .2, roughness .35 to .9, to 80 degrees at 0, 45 and 90 of azimuth, worst 1.1, 5 and 14 % of the albedo."""

# --- lobes outside (lobe_set.py) ---
LOBE_BEND = 0.8
