// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The closure of an interface below vacuum, with the exact Fresnel curve. From Blender 5.3 on Cycles gives a dielectric the inverse
// index on a back face, as if it were seen from inside; a metal without extinction has the same curve on both sides (exactly from
// 5.0 on; in 4.5 it is .041 for .040 along the normal and .135 for .089 at 60 degrees, at index 1.5).
closure color interface_bsdf(normal n, vector t, float alpha_x, float alpha_y, float ior, string distribution)
{
    if (backfacing())
        return conductor_bsdf(n, t, alpha_x, alpha_y, color(ior), color(0.0), distribution);
    return dielectric_bsdf(n, t, color(1.0), color(0.0), alpha_x, alpha_y, ior, distribution);
}
