// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// As interface_bsdf() of interface.h, with a thin film. An exponent below 0 stands for the exact curve of that index.
closure color filmed_interface_bsdf(normal n, vector t, float alpha_x, float alpha_y, float ior, string distribution, float film_nm, float film_ior)
{
    if (backfacing())
        return conductor_bsdf(n, t, alpha_x, alpha_y, color(ior), color(0.0), distribution, "thinfilm_thickness", film_nm, "thinfilm_ior", film_ior);
    float f0 = (ior - 1.0) * (ior - 1.0) / ((ior + 1.0) * (ior + 1.0));
    return generalized_schlick_bsdf(n, t, color(1.0), color(0.0), alpha_x, alpha_y, color(f0), color(1.0), -ior, distribution,
                                    "thinfilm_thickness", film_nm, "thinfilm_ior", film_ior);
}
