// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "lobe_facet.h"
#include "throughput.h"
#include "fresnel_conductor.h"
// Weight of the closure of a metal below `depth` interfaces: the component's energy over the closure's own.
color weight_metal(float nodes[], int depth, float lobe_alpha, int lobe_beckmann, float n[], float alpha[], int beckmann[], color tau[],
                   float view_z, color eta, color k)
{
    color component = color(0.0);
    float closure_energy = 0.0;
    Passage outer, inner;
    for (int s = 0; s < NODE_COUNT; ++s) {
        float weight = lobe_facet(nodes, s, lobe_alpha, lobe_beckmann, view_z, outer);
        if (weight > 0.0) {
            closure_energy += weight * masking_g2(outer.z_i, view_z, lobe_alpha, lobe_beckmann);
            color left = throughput(depth, n, alpha, beckmann, tau, outer, inner);
            color fresnel = fresnel_conductor(inner.cos_h, eta / n[depth], k / n[depth]);
            component += weight * inner_masking(outer, inner, lobe_alpha, lobe_beckmann) * left * fresnel;
        }
    }
    return component / max(closure_energy, 1e-20);
}
