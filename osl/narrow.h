// SPDX-License-Identifier: GPL-3.0-or-later
// Cycles evaluates an isotropic lobe from 1 - cos^2 in float32, which is up to 8 % wrong at alpha .002; an anisotropic
// one from the half vector's own coordinates, which is exact. A narrow lobe is told as very slightly anisotropic.
float across(float alpha)
{
    return alpha < @NARROW_ALPHA@ ? alpha * 1.000001 : alpha;
}
