// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "analytic_below.h"
#include "analytic_metal.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define RETAINED_ORDER 1.0
#define RETAINED_SCALE 1.0
#define REMIX_BACK 1.0
#define REMIX_POWER 1.0
#define REMIX_SCALE 1.0

// One direction of a metal's lobe on its way out through the layers; `cell` is the range of slopes that it stands for.
void carry_node(output Lobe m, Below below, color share, float radius, float cell)
{
    color back, out;
    shares_below(below, below.n_base * radius, m.spread * cell, back, out);
    m.first += share * out;
    m.returned += share * back;
    m.out_again += share * back * out;
    m.back_again += share * back * back;
}

// Energy outside per unit that reaches the base, all orders; `reflected` and `escaped` are the layers' for uniform light.
color metal_energy(Lobe m, color facets, float keep, float alpha, float roughest, color reflected, color escaped)
{
    color once = m.once * keep + facets;
    color scale = max(m.returned, color(1e-12));
    color out_again = m.out_again / scale;
    color back_again = m.back_again / scale;
    color retained = out_again * (1.0 - RETAINED_ORDER * roughest / (roughest + RETAINED_SCALE));
    back_again += out_again - retained;
    float total_alpha = min(sqrt(alpha * alpha + m.widened * m.widened), 1.0);
    float width = pow(total_alpha, REMIX_POWER);
    out_again = mix(retained, escaped, width / (width + REMIX_SCALE));
    back_again = mix(back_again, reflected, width / (width + REMIX_BACK));
    color later = (m.returned * keep + facets * reflected) * once * out_again / (1.0 - once * back_again);
    return m.first * keep + facets * escaped + later;
}
