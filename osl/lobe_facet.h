// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "crossing.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define NODE_COUNT 1

// Facet s of a lobe, of fixed normals of density D cos(h), that shows the view its light: its weight, 0 where it is turned
// away, and the light's way. `nodes` holds u, then cos(phi), then the weight of each.
float lobe_facet(float nodes[], int s, float lobe_alpha, int lobe_beckmann, float view_z, output Passage outer)
{
    float u = nodes[s];
    float tan2 = lobe_alpha * lobe_alpha * (lobe_beckmann ? -log(1.0 - u) : u / (1.0 - u));
    outer.z_h = 1.0 / sqrt(1.0 + tan2);
    outer.cos_h = outer.z_h * (view_z + sqrt(tan2) * nodes[NODE_COUNT + s] * sqrt(max(1.0 - view_z * view_z, 0.0)));
    outer.z_i = 2.0 * outer.cos_h * outer.z_h - view_z;
    outer.z_o = view_z;
    return outer.cos_h > 0.0 && outer.z_i > 0.0 ? nodes[2 * NODE_COUNT + s] * outer.cos_h / outer.z_h : 0.0;
}

// Masking of the facet in the directions below the interfaces, per masking cosine of those above.
float inner_masking(Passage outer, Passage inner, float lobe_alpha, int lobe_beckmann)
{
    return masking_g2(inner.z_i, inner.z_o, lobe_alpha, lobe_beckmann) * outer.z_i * outer.z_o / (inner.z_i * inner.z_o);
}
