// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fresnel_dielectric.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define UNIT 1.0
#define MOST_RHO 1.0
#define RHO_CELLS 1
#define ALPHA_CELLS 1
#define T_KNOTS 2
#define V_KNOTS 2
#define CLOSURE_CELLS 1
#define THIN 0
#define DENSE 0
#define DIFFUSE 0
#define GAIN 0
#define CLOSURE 0

// Energies of rough interfaces and closures from tables, in units of UNIT. The array holds for each distribution ("kind") in
// use the blocks below. No branches on what varies: OSL folds constants within straight lines only.
float trilinear(float table[], int start, float eta, float alpha, float place, int count)
{
    float rho = min(abs(eta - 1.0) / (eta + 1.0) / MOST_RHO, 1.0);
    int i = min((int)(sqrt(rho) * RHO_CELLS), RHO_CELLS - 1);
    int j = min((int)(sqrt(alpha) * ALPHA_CELLS), ALPHA_CELLS - 1);
    int k = min((int)place, count - 2);
    float f = (rho * (RHO_CELLS * RHO_CELLS) - i * i) / (2 * i + 1);
    float g = (alpha * (ALPHA_CELLS * ALPHA_CELLS) - j * j) / (2 * j + 1);
    float h = place - k;
    int at = start + (i * (ALPHA_CELLS + 1) + j) * count + k;
    int next = at + (ALPHA_CELLS + 1) * count;
    float low = table[at] + (table[at + 1] - table[at]) * h;
    float low_rough = table[at + count] + (table[at + count + 1] - table[at + count]) * h;
    float high = table[next] + (table[next + 1] - table[next]) * h;
    float high_rough = table[next + count] + (table[next + count + 1] - table[next + count]) * h;
    low += (low_rough - low) * g;
    high += (high_rough - high) * g;
    return (low + (high - low) * f) * UNIT;
}

// Directional reflectance of a rough interface for light at this cosine in the medium it comes from; eta != 1.
float rough_reflectance(float table[], int kind, float cos_theta, float alpha, float eta)
{
    float c = clamp(cos_theta, 0.0, 1.0);
    float remainder = 0.0;
    if (alpha > 0.0) {
        // from the denser side 0 is at the critical angle, what is negative lies beyond it
        float critical2 = max(1.0 - eta * eta, 0.0);
        float v = sqrt(max(c * c - critical2, 0.0)) / eta - sqrt(max(1.0 - c * c / critical2, 0.0));
        int thin = eta > 1.0;
        float place = thin * sqrt(c) * (T_KNOTS - 1) + (1 - thin) * (v + 1.0) * 0.5 * (V_KNOTS - 1);
        remainder = trilinear(table, kind + thin * THIN + (1 - thin) * DENSE, eta, alpha, place, thin * T_KNOTS + (1 - thin) * V_KNOTS);
    }
    return clamp(fresnel_dielectric(c, eta) + remainder, 0.0, 1.0);
}

// Reflectance for uniform light; from the denser side by reciprocity.
float diffuse_reflectance(float table[], int kind, float alpha, float eta)
{
    float rho = min(abs(eta - 1.0) / (eta + 1.0) / MOST_RHO, 1.0);
    int i = min((int)(sqrt(rho) * RHO_CELLS), RHO_CELLS - 1);
    int j = min((int)(sqrt(alpha) * ALPHA_CELLS), ALPHA_CELLS - 1);
    float f = (rho * (RHO_CELLS * RHO_CELLS) - i * i) / (2 * i + 1);
    float g = (alpha * (ALPHA_CELLS * ALPHA_CELLS) - j * j) / (2 * j + 1);
    int at = kind + DIFFUSE + i * (ALPHA_CELLS + 1) + j;
    int next = at + ALPHA_CELLS + 1;
    float low = table[at] + (table[at + 1] - table[at]) * g;
    float high = table[next] + (table[next + 1] - table[next]) * g;
    float thin = (low + (high - low) * f) * UNIT;
    return eta > 1.0 ? thin : 1.0 - (1.0 - thin) * eta * eta;
}

// Energy of the top interface over that of its closure.
float top_gain(float table[], int kind, float cos_theta_o, float alpha, float eta)
{
    if (alpha == 0.0)
        return 1.0;
    return 1.0 + trilinear(table, kind + GAIN, eta, alpha, sqrt(cos_theta_o) * (T_KNOTS - 1), T_KNOTS);
}

// Directional albedo of a white glossy closure.
float closure_energy(float table[], int kind, float cos_theta_o, float alpha)
{
    float a = sqrt(clamp(alpha, 0.0, 1.0)) * CLOSURE_CELLS;
    float c = sqrt(clamp(cos_theta_o, 0.0, 1.0)) * CLOSURE_CELLS;
    int i = min((int)a, CLOSURE_CELLS - 1);
    int j = min((int)c, CLOSURE_CELLS - 1);
    int at = kind + CLOSURE + i * (CLOSURE_CELLS + 1) + j;
    int next = at + CLOSURE_CELLS + 1;
    float low = table[at] + (table[at + 1] - table[at]) * (c - j);
    float high = table[next] + (table[next + 1] - table[next]) * (c - j);
    return (low + (high - low) * (a - i)) * UNIT;
}
