// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Directional albedo of the energy-preserving Oren-Nayar model (Fujii 2012, OpenPBR 1.0); sigma is its roughness.
color oren_nayar_albedo(float cos_theta, color c, float sigma)
{
    float g0 = M_PI_2 - 2.0 / 3.0;
    float a = 1.0 / (M_PI + sigma * g0);
    float b = sigma * a;
    float z = clamp(cos_theta, 1e-6, 1.0);
    float s = sqrt(max(1.0 - z * z, 0.0));
    float g = s * (acos(z) - 2.0 / 3.0 - s * z) + 2.0 / 3.0 * (s / z) * (1.0 - s * s * s);
    float mean = a * M_PI + (2.0 * M_PI - 5.6) / 3.0 * b;
    float single = a * M_PI + b * g;
    return c * single + c * c * mean * (1.0 - single) / (1.0 - c * (1.0 - mean));
}
