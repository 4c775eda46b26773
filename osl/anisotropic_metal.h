// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "analytic_metal.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define ANISOTROPIC_RETAINED 1.0

// As later_facets, which gave `isotropic`, the more the alphas differ: light between anisotropic facets stays near the plane that it came in.
color later_anisotropic_facets(color isotropic, Lobe m, float energy, float alpha_x, float alpha_y)
{
    float x2 = alpha_x * alpha_x;
    float y2 = alpha_y * alpha_y;
    color mean_fresnel = m.again / max(m.hidden, 1e-9);
    float hidden = 1.0 - energy;
    color planar = mean_fresnel * hidden * mean_fresnel * (1.0 - ANISOTROPIC_RETAINED * hidden) / (1.0 - mean_fresnel * ANISOTROPIC_RETAINED * hidden);
    return mix(isotropic, planar, (x2 - y2) / max(x2 + y2, 1e-20));
}
