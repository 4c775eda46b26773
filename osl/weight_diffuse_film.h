// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diffuse_light.h"
#include "throughput_film.h"
// What `depth` interfaces, which may carry films, leave of a diffuse base's energy.
color weight_diffuse(float nodes[], int depth, float n[], float alpha[], int beckmann[], color tau[], float sensitivity[], float film_nm[], float film_ior[],
                     float view_z, float sigma)
{
    color component = color(0.0);
    float closure_energy = 0.0;
    Passage outer, inner;
    for (int s = 0; s < NODE_COUNT; ++s) {
        float weight = nodes[2 * NODE_COUNT + s];
        float cos_io = diffuse_light(nodes, s, view_z, outer);
        closure_energy += weight * diffuse_lobe(cos_io, outer.z_i, view_z, sigma);
        color left = throughput(depth, n, alpha, beckmann, tau, sensitivity, film_nm, film_ior, outer, inner);
        component += weight * left * diffuse_lobe(2.0 * inner.cos_h * inner.cos_h - 1.0, inner.z_i, inner.z_o, sigma);
    }
    return component / closure_energy;
}
