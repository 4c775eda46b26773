// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Unpolarised Fresnel reflectance of a conductor of relative complex index eta + i k (Born and Wolf 1999, section 14.4).
float fresnel_conductor_channel(float cos_theta_i, float eta, float k)
{
    float c2 = cos_theta_i * cos_theta_i;
    float s2 = 1.0 - c2;
    float t0 = eta * eta - k * k - s2;
    float a2b2 = sqrt(t0 * t0 + 4.0 * eta * eta * k * k);
    float a = sqrt(max(0.5 * (a2b2 + t0), 0.0));
    float t2 = 2.0 * cos_theta_i * a;
    float r_s = (a2b2 + c2 - t2) / (a2b2 + c2 + t2);
    float t3 = c2 * a2b2 + s2 * s2;
    float t4 = t2 * s2;
    return 0.5 * r_s * (1.0 + (t3 - t4) / (t3 + t4));
}

color fresnel_conductor(float cos_theta_i, color eta, color k)
{
    float c = clamp(cos_theta_i, 0.0, 1.0);
    return color(fresnel_conductor_channel(c, eta[0], k[0]),
                 fresnel_conductor_channel(c, eta[1], k[1]),
                 fresnel_conductor_channel(c, eta[2], k[2]));
}
