// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Unpolarised Fresnel reflectance of a dielectric interface, eta = n_t / n_i in travel direction
// (Born and Wolf 1999, section 1.5). 1 beyond the critical angle, where g is 0; an interface between equal media vanishes.
float fresnel_dielectric(float cos_theta_i, float eta)
{
    float c = clamp(cos_theta_i, 1e-6, 1.0);
    float g = sqrt(max(eta * eta - 1.0 + c * c, 0.0));
    float r_s = (c - g) / (c + g);
    float r_p = (eta * eta * c - g) / (eta * eta * c + g);
    return 0.5 * (r_s * r_s + r_p * r_p);
}
