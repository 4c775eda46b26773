// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "crossing.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define NODE_COUNT 1

// Angular part of a diffuse lobe: 1 for Lambert (sigma 0), Oren and Nayar's otherwise.
float diffuse_lobe(float cos_io, float z_i, float z_o, float sigma)
{
    float t = cos_io - z_i * z_o;
    return 1.0 + sigma * (t > 0.0 ? t / max(z_i, z_o) : t);
}

// The way of light s, of fixed directions of cosine density, to the view; `nodes` as for lobe_facet(). Gives the cosine of the two.
float diffuse_light(float nodes[], int s, float view_z, output Passage outer)
{
    float view_sin = sqrt(max(1.0 - view_z * view_z, 0.0));
    outer.z_i = sqrt(nodes[s]);
    outer.z_o = view_z;
    float cos_io = outer.z_i * view_z + sqrt(1.0 - nodes[s]) * nodes[NODE_COUNT + s] * view_sin;
    outer.cos_h = sqrt(max(0.5 * (1.0 + cos_io), 0.0));
    outer.z_h = 0.5 * (outer.z_i + view_z) / max(outer.cos_h, 1e-6);
    return cos_io;
}
