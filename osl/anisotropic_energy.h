// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "analytic_tables.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define UNIT 1.0
#define ANISOTROPIC 0
#define ANISOTROPIC_ALPHAS 1
#define ANISOTROPIC_RATIOS 1
#define ANISOTROPIC_COSINES 1
#define ANISOTROPIC_KNOTS_0 1.0
#define ANISOTROPIC_KNOTS_1 1.0
#define ANISOTROPIC_KNOTS_2 1.0
#define ANISOTROPIC_KNOTS_3 1.0
#define LEAST_KAPPA 1.0
#define LEAST_RATIO 1.0

// Anisotropic surfaces: what a view at an azimuth meets. See reference_py/lobes/analytic/interface_tables.py and lobes/methods/with_features.py.
// cos 2 phi of the azimuth between the view and the tangent; any where the view is along the normal.
float cos_twice_azimuth(vector view, normal n, vector tangent)
{
    vector side = view - dot(view, n) * n;
    float c = dot(side, tangent);
    return clamp(2.0 * c * c / max(dot(side, side), 1e-12) - 1.0, -1.0, 1.0);
}

// Alphas along the plane of incidence and, with -cos_2phi, across it.
float side_alpha(float alpha_x, float alpha_y, float cos_2phi)
{
    return sqrt(0.5 * ((1.0 + cos_2phi) * alpha_x * alpha_x + (1.0 - cos_2phi) * alpha_y * alpha_y));
}

// Alpha of the isotropic interface that reflects as much of the view.
float seen_alpha(float alpha_x, float alpha_y, float cos_2phi, float view_z)
{
    float along = side_alpha(alpha_x, alpha_y, cos_2phi);
    float across = side_alpha(alpha_x, alpha_y, -cos_2phi);
    return sqrt((along * along + view_z * view_z * across * across) / (1.0 + view_z * view_z));
}

// In what energies are smooth over the azimuth.
float azimuth_place(float cos_2phi, float tan2, float mean2, float gap, float kappa)
{
    if (kappa <= LEAST_KAPPA)
        return cos_2phi;
    return log((1.0 + tan2 * (mean2 + gap * cos_2phi)) / (1.0 + tan2 * mean2)) / kappa;
}

// Directional albedo of a white anisotropic closure, alpha_x >= alpha_y.
float anisotropic_energy(float table[], int kind, float cos_theta_o, float cos_2phi, float alpha_x, float alpha_y)
{
    float x2 = alpha_x * alpha_x;
    float y2 = alpha_y * alpha_y;
    float mean2 = 0.5 * (x2 + y2);
    float gap = 0.5 * (x2 - y2);
    float z = clamp(cos_theta_o, 1e-4, 1.0);
    float ratio = clamp(sqrt(y2 / max(x2, 1e-20)), LEAST_RATIO, 1.0);
    float a = sqrt(clamp(sqrt(mean2), 0.0, 1.0)) * ANISOTROPIC_ALPHAS;
    float r = log(ratio) / log(LEAST_RATIO) * ANISOTROPIC_RATIOS;
    float c = sqrt(z) * ANISOTROPIC_COSINES;
    int i = min((int)a, ANISOTROPIC_ALPHAS - 1);
    int j = min((int)r, ANISOTROPIC_RATIOS - 1);
    int k = min((int)c, ANISOTROPIC_COSINES - 1);
    float tan2 = 1.0 / (z * z) - 1.0;
    float kappa = tan2 * gap / (1.0 + tan2 * mean2);
    float place = azimuth_place(cos_2phi, tan2, mean2, gap, kappa);
    float knots[4] = {ANISOTROPIC_KNOTS_0, ANISOTROPIC_KNOTS_1, ANISOTROPIC_KNOTS_2, ANISOTROPIC_KNOTS_3};
    float places[4];
    for (int p = 0; p < 4; ++p)
        places[p] = azimuth_place(knots[p], tan2, mean2, gap, kappa);
    float total = closure_energy(table, kind, cos_theta_o, sqrt(mean2));
    int rows = ANISOTROPIC_COSINES + 1;
    int sheets = (ANISOTROPIC_RATIOS + 1) * rows;
    for (int p = 0; p < 4; ++p) {
        int at = kind + ANISOTROPIC + ((p * (ANISOTROPIC_ALPHAS + 1) + i) * (ANISOTROPIC_RATIOS + 1) + j) * rows + k;
        float low = mix(mix(table[at], table[at + 1], c - k), mix(table[at + rows], table[at + rows + 1], c - k), r - j);
        at += sheets;
        float high = mix(mix(table[at], table[at + 1], c - k), mix(table[at + rows], table[at + rows + 1], c - k), r - j);
        float basis = 1.0;
        for (int q = 0; q < 4; ++q)
            if (q != p)
                basis *= (place - places[q]) / (places[p] - places[q]);
        total += basis * mix(low, high, a - i) * UNIT;
    }
    return total;
}
