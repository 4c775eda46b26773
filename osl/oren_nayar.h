// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cycles' roughness of an Oren-Nayar closure: B / A of Oren and Nayar 1994, from their sigma in degrees.
float oren_nayar_sigma(float degrees)
{
    float sigma2 = degrees * degrees * (M_PI / 180.0) * (M_PI / 180.0);
    return (0.45 * sigma2 / (sigma2 + 0.09)) / (1.0 - 0.5 * sigma2 / (sigma2 + 0.33));
}

// Weight of the white Oren-Nayar closure in that of a color; the rest of the color meets one facet alone. Cycles' closure has
// the color's square from Blender 5.3 on, its cube before, in light that meets several facets: white and black are the same.
color oren_nayar_white(color c, float sigma)
{
    float mean = (M_PI + (2.0 * M_PI - 5.6) / 3.0 * sigma) / (M_PI + sigma * (M_PI_2 - 2.0 / 3.0));
    return c * c * mean / (1.0 - c * (1.0 - mean));
}
