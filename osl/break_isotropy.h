// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define NEAR_SPECULAR_ALPHA 1.0

// Cycles evaluates an isotropic lobe from 1 - cos^2 in float32, which is up to 8 % wrong at alpha .002; an anisotropic
// one from the half vector's own coordinates, which is exact. So a nearly specular lobe gets a very slight anisotropy.
float break_isotropy(float alpha)
{
    return alpha < NEAR_SPECULAR_ALPHA ? alpha * 1.000001 : alpha;
}

// The second alpha of a lobe that may be isotropic at some views alone.
float break_isotropy(float alpha_x, float alpha_y)
{
    return alpha_x == alpha_y ? break_isotropy(alpha_y) : alpha_y;
}
