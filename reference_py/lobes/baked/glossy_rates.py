# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes as fits ask for them: f in few steps, and its derivatives by a lobe's shape. Most steps overwrite what they read: fits spend much of their time here.

Of directions, wo is (x, z) in the plane of incidence and wi (x, y, z), each (...); alphas and tilt broadcast.
"""

import numpy as np

from ...optics.microfacet import distribution_of


def glossy_values(distribution: str, alpha_x, alpha_y, tilt, wo: tuple, wi: tuple) -> np.ndarray:
    """f (...) as `closure.unit_glossy` has it."""
    law = distribution_of(distribution)
    into, out, lean, across, seen = _slopes(tilt, wo, wi)
    lean *= lean
    across *= across
    value = lean + across
    value += 1.0
    value *= value
    lean *= 1.0 / np.square(alpha_x)
    across *= 1.0 / np.square(alpha_y)
    lean += across
    value *= law.slope_density(lean)
    along, aside = into
    along *= alpha_x
    along *= along
    aside *= alpha_y
    aside *= aside
    along += aside
    masked = law.smith_lambda(along)
    masked += law.smith_lambda(np.square(alpha_x * out[0]))
    masked += 1.0
    value /= masked
    return _scaled(value, alpha_x, alpha_y, out[1], wi[2], seen)


def glossy_rates(distribution: str, alpha_x, alpha_y, tilt, wo: tuple, wi: tuple) -> tuple[np.ndarray, ...]:
    """f (...) as `closure.unit_glossy` has it, and its derivatives by log alpha_x, log alpha_y and the tilt."""
    law = distribution_of(distribution)
    (along, aside), (along_o, oz), lean, across, seen = _slopes(tilt, wo, wi)
    lean2, across2 = lean * lean, across * across
    narrow_x, narrow_y = 1.0 / np.square(alpha_x), 1.0 / np.square(alpha_y)
    x2, y2 = lean2 * narrow_x, across2 * narrow_y
    slope2 = x2 + y2
    by_slope2 = law.log_slope_density_rate(slope2)
    by_slope2 *= -2.0
    into = _masking_rates(law, alpha_x, alpha_y, along, aside)
    out = _masking_rates(law, alpha_x, alpha_y, along_o, 0.0)
    g2 = into[0] + out[0]
    g2 += 1.0
    np.divide(1.0, g2, out=g2)
    value = lean2
    value += across2
    value += 1.0
    value *= value
    value *= law.slope_density(slope2)
    value *= g2
    value = _scaled(value, alpha_x, alpha_y, oz, wi[2], seen)
    slope2 += narrow_x
    slope2 *= by_slope2
    slope2 -= 4.0
    lean *= slope2
    x2 *= by_slope2
    y2 *= by_slope2
    for rate, less, masked_in, masked_out in zip((x2, y2, lean), (1.0, 1.0, along_o), into[1:], out[1:]):
        masked_in += masked_out
        masked_in *= g2
        rate -= less
        rate -= masked_in
        rate *= value
    return value, x2, y2, lean


def _slopes(tilt, wo: tuple, wi: tuple) -> tuple:
    """In the lobe's frame: wi's slopes along the plane of incidence and across, wo's slope and its cosine, the half vector's slopes, and what is
    seen from both sides; the first and the half vector's may be overwritten."""
    cos_t, sin_t = np.cos(tilt), np.sin(tilt)
    x, iy, z = wi
    ix, iz = cos_t * x, cos_t * z
    ix -= sin_t * z
    iz += sin_t * x
    ox, oz = cos_t * wo[0] - sin_t * wo[1], cos_t * wo[1] + sin_t * wo[0]
    seen = (oz > 0.0) & (iz > 0.0)
    iz, oz = np.where(seen, iz, 1.0), np.where(oz > 0.0, oz, 1.0)
    inverse_z = 1.0 / (iz + oz)
    lean, across = ix + ox, iy * inverse_z
    lean *= inverse_z
    inverse_z = np.divide(1.0, iz, out=inverse_z)
    ix *= inverse_z
    inverse_z *= iy
    return (ix, inverse_z), (ox / oz, oz), lean, across, seen


def _scaled(value, alpha_x, alpha_y, oz, z, seen):
    """f of what the slopes say, which is overwritten."""
    value *= seen * (0.25 / (np.pi * alpha_x * alpha_y * oz))
    value /= z
    return value


def _masking_rates(law, alpha_x, alpha_y, lean, across) -> tuple:
    """Smith's Lambda of directions of slopes `lean` and `across`, and its derivatives as `glossy_rates` has them."""
    along = np.square(alpha_x)
    x2, y2 = along * (lean * lean), np.square(alpha_y) * (across * across)
    total = x2 + y2
    value, rate = law.smith_lambda_and_rate(total)
    rate = 2.0 * rate
    x2 *= rate
    y2 = y2 * rate
    total += along
    total *= lean
    total *= -rate
    return value, x2, y2, total
