// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "analytic_cosine.h"
#include "fresnel_conductor.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define BASE_LOSS 1.0
#define EXIT_SPREAD 1.0
#define LEAST_COS 1.0
#define MOST_LOBE_SHARE 1.0
#define NODE_SPREAD 1.0
#define MEAN_WEIGHT_0 1.0
#define MEAN_WEIGHT_1 1.0
#define MEAN_WEIGHT_2 1.0
#define MEAN_WEIGHT_3 1.0
#define MEAN_COSINE_0 1.0
#define MEAN_COSINE_1 1.0
#define MEAN_COSINE_2 1.0
#define MEAN_COSINE_3 1.0

// A metal base: its lobe at a few directions from its visible facets, each carried out through the layers.
// See reference_py/lobes/analytic/base.py.
struct Lobe {
    // of the beam that arrives: cosine, sine, spread as an alpha, and the spread of p that the lobe has
    float c;
    float s;
    float widened;
    float spread;
    // sums over the nodes
    float seen;
    float hidden;
    color once;
    color again;
    color first;
    color returned;
    color out_again;
    color back_again;
};

// Smith's Lambda of a GGX surface where alpha tan of the direction is known.
float stretched_lambda(float stretched)
{
    return 0.5 * (sqrt(1.0 + stretched * stretched) - 1.0);
}

// A node of the cap and the share of the lobe that it stands for; p: where it goes. Alphas along and across the plane of incidence.
void lobe_node(output Lobe m, float u, float weight, float turn_x, float turn_y, float alpha_along, float alpha_across, int beckmann,
               int spread_beckmann, color eta, color k, output color share, output float radius)
{
    float ggx = sqrt(u / (1.0 - u));
    float gauss = sqrt(-log(1.0 - u));
    float own = beckmann ? gauss : ggx;
    float above = m.widened * (spread_beckmann ? gauss : ggx);
    float along = alpha_along * own / ggx;
    float side = alpha_across * own / ggx;
    float apart_x = sqrt(alpha_along * alpha_along * own * own + above * above) - alpha_along * own;
    float apart_y = sqrt(alpha_across * alpha_across * own * own + above * above) - alpha_across * own;
    float size = sqrt(along * along * m.s * m.s + m.c * m.c);
    float ax = along * m.s / size;
    float az = m.c / size;
    float hz = (1.0 - u) * (1.0 + az);
    float ring = sqrt(max(1.0 - (hz - az) * (hz - az), 0.0));
    float hx = along * (ring * turn_x + ax);
    float hy = side * ring * turn_y;
    size = sqrt(hx * hx + hy * hy + hz * hz);
    hx /= size;
    hy /= size;
    hz /= size;
    float cos_om = m.s * hx + m.c * hz;
    float iz = 2.0 * cos_om * hz - m.c;
    float ix = 2.0 * cos_om * hx - m.s;
    float iy = 2.0 * cos_om * hy;
    float lambda_o = stretched_lambda(along * m.s / m.c);
    float lambda_i = stretched_lambda(sqrt(along * along * ix * ix + side * side * iy * iy) / max(iz, LEAST_COS));
    float seen = iz > 0.0 ? (1.0 + lambda_o) / (1.0 + lambda_o + lambda_i) : 0.0;
    color fresnel = fresnel_conductor(min(cos_om, 1.0), eta, k);
    ix += 2.0 * m.c * apart_x * turn_x;
    iy += 2.0 * m.c * apart_y * turn_y;
    radius = min(sqrt(ix * ix + iy * iy), MOST_LOBE_SHARE);
    m.seen += weight * seen;
    m.hidden += weight * (1.0 - seen);
    m.again += weight * (1.0 - seen) * fresnel;
    share = weight * seen * fresnel;
    m.once += share;
}

void start_lobe(output Lobe m, float p, float variance, float n, float alpha)
{
    m.c = cosine(p, n);
    m.s = min(p / n, 1.0);
    m.widened = sqrt(variance * EXIT_SPREAD) / (2.0 * n * m.c);
    m.spread = NODE_SPREAD * 2.0 * n * m.c * min(sqrt(alpha * alpha + m.widened * m.widened), 1.0);
    m.seen = 0.0;
    m.hidden = 0.0;
    m.once = color(0.0);
    m.again = color(0.0);
    m.first = color(0.0);
    m.returned = color(0.0);
    m.out_again = color(0.0);
    m.back_again = color(0.0);
}

// What facets let go only after they met another, and `keep`: the nodes know the lobe's shape, `energy` is what white ones let go at once.
color later_facets(Lobe m, float energy, float alpha, color eta, color k, output float keep)
{
    keep = energy / m.seen;
    color mean_fresnel = MEAN_WEIGHT_0 * fresnel_conductor(MEAN_COSINE_0, eta, k) + MEAN_WEIGHT_1 * fresnel_conductor(MEAN_COSINE_1, eta, k)
        + MEAN_WEIGHT_2 * fresnel_conductor(MEAN_COSINE_2, eta, k) + MEAN_WEIGHT_3 * fresnel_conductor(MEAN_COSINE_3, eta, k);
    float lost = BASE_LOSS * alpha * alpha / (1.0 + (1.0 + BASE_LOSS) * alpha * alpha);
    return m.again * (1.0 - energy) / max(m.hidden, 1e-9) * mean_fresnel * (1.0 - lost) / (1.0 - mean_fresnel * lost);
}
