// SPDX-License-Identifier: GPL-3.0-or-later
// Energies of rough interfaces and closures from tables. The array holds the knots of rho and alpha, then for each
// distribution ("kind") in use the blocks below, in units of 1.
int cell_of(float table[], int start, int count, float x)
{
    int cell = 0;
    for (int k = 1; k < count - 1; ++k)
        cell += x >= table[start + k];
    return cell;
}

float bilinear(float table[], int start, int row, float f, float g)
{
    return mix(mix(table[start], table[start + 1], g), mix(table[start + row], table[start + row + 1], g), f);
}

float trilinear(float table[], int start, float rho, float alpha, float place, int count)
{
    int i = cell_of(table, 0, RHO_KNOTS, rho);
    int j = cell_of(table, RHO_KNOTS, ALPHA_KNOTS, alpha);
    int k = clamp((int)floor(place), 0, count - 2);
    float f = clamp((rho - table[i]) / (table[i + 1] - table[i]), 0.0, 1.0);
    float g = clamp((alpha - table[RHO_KNOTS + j]) / (table[RHO_KNOTS + j + 1] - table[RHO_KNOTS + j]), 0.0, 1.0);
    float h = clamp(place - k, 0.0, 1.0);
    int at = start + (i * ALPHA_KNOTS + j) * count + k;
    return mix(bilinear(table, at, count, g, h), bilinear(table, at + ALPHA_KNOTS * count, count, g, h), f);
}

float rho_of(float eta)
{
    return abs(eta - 1.0) / (eta + 1.0);
}

// Directional reflectance of a rough interface for light at this cosine in the medium it comes from.
float rough_reflectance(float table[], int kind, float cos_theta, float alpha, float eta)
{
    if (eta == 1.0)
        return 0.0;
    float c = clamp(cos_theta, 0.0, 1.0);
    int start = TABLES + kind * TABLES_OF_KIND;
    float rest;
    if (eta > 1.0) {
        rest = trilinear(table, start + THIN, rho_of(eta), alpha, sqrt(c) * (T_KNOTS - 1), T_KNOTS);
    } else {
        float critical2 = 1.0 - eta * eta;
        float v = c * c < critical2 ? -sqrt(max(1.0 - c * c / critical2, 0.0)) : sqrt(max(c * c - critical2, 0.0)) / eta;
        rest = trilinear(table, start + DENSE, rho_of(eta), alpha, (v + 1.0) * 0.5 * (V_KNOTS - 1), V_KNOTS);
    }
    return clamp(fresnel_dielectric(c, eta) + rest, 0.0, 1.0);
}

// Reflectance for uniform light; from the denser side by reciprocity.
float diffuse_reflectance(float table[], int kind, float alpha, float eta)
{
    if (eta == 1.0)
        return 0.0;
    float rho = rho_of(eta);
    int i = cell_of(table, 0, RHO_KNOTS, rho);
    int j = cell_of(table, RHO_KNOTS, ALPHA_KNOTS, alpha);
    float f = clamp((rho - table[i]) / (table[i + 1] - table[i]), 0.0, 1.0);
    float g = clamp((alpha - table[RHO_KNOTS + j]) / (table[RHO_KNOTS + j + 1] - table[RHO_KNOTS + j]), 0.0, 1.0);
    float thin = bilinear(table, TABLES + kind * TABLES_OF_KIND + DIFFUSE + i * ALPHA_KNOTS + j, ALPHA_KNOTS, f, g);
    return eta > 1.0 ? thin : 1.0 - (1.0 - thin) * eta * eta;
}

// Energy of the top interface over that of its closure.
float top_gain(float table[], int kind, float cos_theta_o, float alpha, float eta)
{
    return trilinear(table, TABLES + kind * TABLES_OF_KIND + GAIN, rho_of(eta), alpha,
                     sqrt(clamp(cos_theta_o, 0.0, 1.0)) * (T_KNOTS - 1), T_KNOTS);
}

// Directional albedo of a white glossy closure.
float closure_energy(float table[], int kind, float cos_theta_o, float alpha)
{
    float a = sqrt(clamp(alpha, 0.0, 1.0)) * CLOSURE_CELLS;
    float c = sqrt(clamp(cos_theta_o, 0.0, 1.0)) * CLOSURE_CELLS;
    int i = min((int)a, CLOSURE_CELLS - 1);
    int j = min((int)c, CLOSURE_CELLS - 1);
    int at = TABLES + kind * TABLES_OF_KIND + CLOSURE + i * (CLOSURE_CELLS + 1) + j;
    return bilinear(table, at, CLOSURE_CELLS + 1, a - i, c - j);
}
