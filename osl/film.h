// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fresnel_dielectric.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define FILM_STEPS 2
#define FILM_LAST_PHASE 1.0
#define FILM_TERMS 1
#define FILM_THINNEST 1.0

// Reflectance of an interface that carries a thin film, per channel, as Cycles computes it: Airy's sum as a series in the
// path difference (Belcour and Barla 2017, eq. 10). `sensitivity` holds, for red, green and blue, the real and then the
// imaginary parts of the transform of the color matching function.
float film_sensitivity(float sensitivity[], int part, float path)
{
    float place = clamp(M_2PI * path / FILM_LAST_PHASE, 0.0, 1.0) * (FILM_STEPS - 1);
    int cell = min((int)place, FILM_STEPS - 2);
    return mix(sensitivity[part * FILM_STEPS + cell], sensitivity[part * FILM_STEPS + cell + 1], place - cell);
}

// One polarisation: r12 is real, r23 has the square `energy` and the direction (re, im), which need not be normalised.
float film_airy(float sensitivity[], int channel, float r12, float energy, float re, float im, float path)
{
    float r2 = r12 * r12;
    float left = 1.0 - r2;
    float once = left * left * energy / max(1.0 - r2 * energy, 1e-9);
    float size = sqrt(re * re + im * im);
    float sign = r12 >= 0.0 ? -1.0 : 1.0;
    float turn_re = size > 0.0 ? sign * re / size : sign;
    float turn_im = size > 0.0 ? sign * im / size : 0.0;
    float at_re = turn_re;
    float at_im = turn_im;
    float total = r2 + once;
    float term = once - left;
    for (int order = 1; order <= FILM_TERMS; ++order) {
        term *= sqrt(r2 * energy);
        total += 2.0 * term * (at_re * film_sensitivity(sensitivity, channel, order * path)
                               + at_im * film_sensitivity(sensitivity, channel + 3, order * path));
        float re_next = at_re * turn_re - at_im * turn_im;
        at_im = at_re * turn_im + at_im * turn_re;
        at_re = re_next;
    }
    return total;
}

// Light comes from a medium of index n_above; the film lies on a dielectric (k = 0) or conductor, all indices absolute.
color film_reflectance(float sensitivity[], float film_nm, float film_ior, float cos_1, float n_above, color n_below, color k_below)
{
    float fade = smoothstep(0.0, 1.0, film_nm);
    float ior = mix(n_above, film_ior, fade);
    float sin2 = n_above * n_above * (1.0 - cos_1 * cos_1);
    float cos2_2 = 1.0 - sin2 / (ior * ior);
    if (cos2_2 <= 0.0)
        return color(1.0);
    float cos_2 = sqrt(cos2_2);
    float r12_s = ior == n_above ? 0.0 : (n_above * cos_1 - ior * cos_2) / (n_above * cos_1 + ior * cos_2);
    float r12_p = ior == n_above ? 0.0 : (ior * cos_1 - n_above * cos_2) / (ior * cos_1 + n_above * cos_2);
    float path = 2.0 * ior * film_nm * cos_2;
    float near = ior * cos_2;
    color result;
    for (int channel = 0; channel < 3; ++channel) {
        float n = n_below[channel];
        float k = k_below[channel];
        // the square of the index, and u + i v, the index times the cosine inside
        float a = n * n - k * k;
        float b = 2.0 * n * k;
        float t1 = a - sin2;
        if (k == 0.0 && t1 <= 0.0) {
            result[channel] = 1.0;
            continue;
        }
        float t2 = sqrt(t1 * t1 + b * b);
        float u = sqrt(max(0.5 * (t2 + t1), 0.0));
        float v = k == 0.0 ? 0.0 : sqrt(max(0.5 * (t2 - t1), 0.0));
        float below = (near + u) * (near + u) + v * v;
        float energy_s = ((near - u) * (near - u) + v * v) / below;
        float re_s = near * near - u * u - v * v;
        float im_s = -2.0 * near * v;
        float x = a * cos_2;
        float y = b * cos_2;
        below = (x + ior * u) * (x + ior * u) + (y + ior * v) * (y + ior * v);
        float energy_p = ((x - ior * u) * (x - ior * u) + (y - ior * v) * (y - ior * v)) / below;
        float re_p = x * x + y * y - ior * ior * (u * u + v * v);
        float im_p = 2.0 * ior * (y * u - x * v);
        result[channel] = 0.5 * clamp(film_airy(sensitivity, channel, r12_s, energy_s, re_s, im_s, path)
                                      + film_airy(sensitivity, channel, r12_p, energy_p, re_p, im_p, path), 0.0, 2.0);
    }
    return result;
}

// Of a dielectric interface that may carry a film.
color interface_reflectance(float sensitivity[], float film_nm, float film_ior, float cos_theta_i, float n_above, float n_below)
{
    if (film_nm <= FILM_THINNEST)
        return color(fresnel_dielectric(cos_theta_i, n_below / n_above));
    return film_reflectance(sensitivity, film_nm, film_ior, clamp(cos_theta_i, 0.0, 1.0), n_above, color(n_below), color(0.0));
}
