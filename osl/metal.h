// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The closure of a metal with its exact Fresnel curve (from Blender 5.0 on). Its index is that of Rec.709's channels: in a working
// space with other primaries each of these is a closure.
closure color metal_bsdf(normal n, vector t, float alpha_x, float alpha_y, color eta, color k, string distribution, color red, color green, color blue)
{
    if (red == color(1.0, 0.0, 0.0) && green == color(0.0, 1.0, 0.0) && blue == color(0.0, 0.0, 1.0))
        return conductor_bsdf(n, t, alpha_x, alpha_y, eta, k, distribution);
    closure color others = green * conductor_bsdf(n, t, alpha_x, alpha_y, color(eta[1]), color(k[1]), distribution) +
                           blue * conductor_bsdf(n, t, alpha_x, alpha_y, color(eta[2]), color(k[2]), distribution);
    return red * conductor_bsdf(n, t, alpha_x, alpha_y, color(eta[0]), color(k[0]), distribution) + others;
}
