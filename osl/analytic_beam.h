// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "analytic_cosine.h"
#include "analytic_tables.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define BACK_SPREAD 1.0
#define LEAN_BECKMANN_0 1.0
#define LEAN_BECKMANN_1 1.0
#define LEAN_BECKMANN_2 1.0
#define LEAN_GGX_0 1.0
#define LEAN_GGX_1 1.0
#define LEAN_GGX_2 1.0
#define LOBE_SPREAD 1.0
#define MOST_SHARE 1.0
#define SPREAD_GRAZING 1.0
#define SPREAD_HALF 1.0
#define SPREAD_INCIDENCE 1.0
#define SPREAD_LIMIT 1.0
#define TAU_SHARE 1.0
#define TAU_SPREAD 1.0
#define TRAPPED_COS 1.0
#define TRAPPED_SPREAD 1.0

// A beam through the layers: adding of scalars. It has a transverse momentum p = n sin(theta), which smooth interfaces
// keep, and a variance of p, to which every rough crossing adds. See reference_py/lobes/analytic/beam.py.
// Everything is in straight lines: what does not depend on the view costs nothing where the parameters are constant.
struct Beam {
    float p;
    float variance;
    // per unit that started: transmitted, reflected by the first interface and by the inner ones
    color transmitted;
    color first;
    color inner;
    // the inner energy times its variance of p outside
    float spread;
    // what is known of the light that comes back to the last interface, and what the media since then leave
    color around;
    color out;
    color left;
};

void start_beam(output Beam b, float p, float variance)
{
    b.p = p;
    b.variance = variance;
    b.transmitted = color(1.0);
    b.first = color(0.0);
    b.inner = color(0.0);
    b.spread = 0.0;
    b.around = color(0.0);
    b.out = color(1.0);
    b.left = color(1.0);
}

float mean(color c)
{
    return (c[0] + c[1] + c[2]) / 3.0;
}

float largest(color c)
{
    return max(c[0], max(c[1], c[2]));
}

// Reflectance for a beam: that of a rougher interface, towards that of uniform light when it is wide.
float widened_reflectance(float table[], int kind, float cos_theta, float variance, float n_own, float eta, float alpha)
{
    float spread = SPREAD_INCIDENCE * variance / (n_own * n_own * cos_theta * cos_theta);
    float wide = spread / (spread + SPREAD_HALF);
    float alpha_wide = min(sqrt(alpha * alpha + spread / (1.0 + spread / SPREAD_LIMIT)), 1.0);
    float directed = rough_reflectance(table, kind, cos_theta, alpha_wide, eta);
    return directed + (diffuse_reflectance(table, kind, alpha, eta) - directed) * wide * wide;
}

// Share that one crossing of a medium leaves of a beam: the mean of its two sides.
color attenuation(color tau, float p, float variance, float n)
{
    float step = TAU_SPREAD * sqrt(variance);
    float low = cosine(abs(p - step), n);
    float high = cosine(min(p + step, max(p, TAU_SHARE * n)), n);
    return 0.5 * (exp(-tau / low) + exp(-tau / high));
}

// A beam after a rough interface refracted it; the facets that it sees lean towards it.
void refract_beam(output Beam b, int beckmann, float alpha, float n1, float n2)
{
    if (alpha > 0.0) {
        float c1 = cosine(b.p, n1);
        float turn = (n2 * cosine(b.p, n2) - n1 * c1) * alpha;
        float t = alpha * sqrt(max(1.0 / (c1 * c1) - 1.0, 0.0));
        float lean = turn * (beckmann ? LEAN_BECKMANN_0 * t / (1.0 + LEAN_BECKMANN_1 * alpha + LEAN_BECKMANN_2 * t)
                                      : LEAN_GGX_0 * t / (1.0 + LEAN_GGX_1 * alpha + LEAN_GGX_2 * t * alpha));
        float spread = turn / (1.0 + SPREAD_GRAZING * t);
        b.variance += LOBE_SPREAD * spread * spread;
        b.p = min(b.p, MOST_SHARE * n2);
        float room = max(MOST_SHARE * n2 - b.p, 1e-3);
        // only one of the two is not 0
        b.p = max(b.p + min(lean, 0.0), 0.0) + room * (1.0 - exp(-max(lean, 0.0) / room));
    }
    b.p = min(b.p, 0.9999 * n2);
}

// What an interface turns back meets the one before from behind, widened: `kind_back`, `alpha_back`, `eta_back` are that
// one's. Gives the share that comes back again to this interface.
color meet_before(output Beam b, float table[], float r12, float c1, float slope, float n1, float eta, int kind_back, float alpha_back,
                  float eta_back)
{
    float wider = b.variance + BACK_SPREAD * slope * slope;
    float r21 = widened_reflectance(table, kind_back, c1, wider, n1, eta_back, alpha_back);
    if (eta < 1.0) {
        float total = clamp((r12 - fresnel_dielectric(c1, eta)) / max(r12, 1e-9), 0.0, 1.0);
        float trapped_cos = TRAPPED_COS * sqrt(1.0 - eta * eta);
        float trapped = widened_reflectance(table, kind_back, trapped_cos, TRAPPED_SPREAD * wider, n1, eta_back, alpha_back);
        r21 += total * max(trapped - r21, 0.0);
    }
    color back = (r21 + (1.0 - r21) * b.around) * b.left * b.left;
    b.out = (1.0 - r21) * b.out * b.left;
    return back;
}

// An interface from n1 to n2; `back` is the share of what it reflects that comes back.
void cross_interface(output Beam b, int beckmann, float alpha, float n1, float n2, float slope, float r12, color back, int top)
{
    color trips = 1.0 / (1.0 - back * r12);
    color lobe = b.transmitted * r12 * b.out * trips;
    b.first += top * lobe;
    b.inner += (1 - top) * lobe;
    b.spread += (1 - top) * mean(lobe) * (2.0 * b.variance + slope * slope);
    b.transmitted *= (1.0 - r12) * trips;
    b.around = (1.0 - r12) * trips * back;
    b.out *= trips;
    b.left = color(1.0);
    refract_beam(b, beckmann, alpha, n1, n2);
}

// The first interface of a beam's way, and the medium behind it.
void cross_first(output Beam b, float table[], int kind, int beckmann, float alpha, float n1, float n2, color tau)
{
    if (n1 != n2) {
        float c1 = cosine(b.p, n1);
        float r12 = widened_reflectance(table, kind, c1, b.variance, n1, n2 / n1, alpha);
        cross_interface(b, beckmann, alpha, n1, n2, 2.0 * n1 * c1 * alpha, r12, color(0.0), 1);
    }
    if (largest(tau) > 0.0) {
        color once = attenuation(tau, b.p, b.variance, n2);
        b.transmitted *= once;
        if (n1 != n2)
            b.left *= once;
        else
            b.out *= once;
    }
}

// A deeper one, or, in loops, any: `top` says whether it is the first.
// `met`: the beam passed an interface before; of the last one: `kind_back`, `alpha_back`, `eta_back`.
void cross_next(output Beam b, float table[], int kind, int beckmann, float alpha, float n1, float n2, color tau,
                int top, int met, int kind_back, float alpha_back, float eta_back)
{
    if (n1 != n2) {
        float eta = n2 / n1;
        float c1 = cosine(b.p, n1);
        float slope = 2.0 * n1 * c1 * alpha;
        float r12 = widened_reflectance(table, kind, c1, b.variance, n1, eta, alpha);
        color back = color(0.0);
        if (met)
            back = meet_before(b, table, r12, c1, slope, n1, eta, kind_back, alpha_back, eta_back);
        cross_interface(b, beckmann, alpha, n1, n2, slope, r12, back, top);
    }
    if (largest(tau) > 0.0) {
        color once = attenuation(tau, b.p, b.variance, n2);
        b.transmitted *= once;
        if (met || n1 != n2)
            b.left *= once;
        else
            b.out *= once;
    }
}
