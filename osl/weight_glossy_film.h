// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "lobe_facet.h"
#include "film.h"
// Weight of the closure of the interface that lies below `depth` interfaces, any of which may carry a film: the component's energy over the closure's own.
// The last turn of the loop is the interface itself: films are long code, and every call is one more copy of it.
color weight_glossy(float nodes[], int depth, float lobe_alpha, int lobe_beckmann, float n[], float alpha[], int beckmann[], color tau[],
                    float sensitivity[], float film_nm[], float film_ior[], float view_z)
{
    color component = color(0.0);
    float closure_energy = 0.0;
    Passage outer, inner;
    for (int s = 0; s < NODE_COUNT; ++s) {
        float weight = lobe_facet(nodes, s, lobe_alpha, lobe_beckmann, view_z, outer);
        if (weight > 0.0) {
            closure_energy += weight * masking_g2(outer.z_i, view_z, lobe_alpha, lobe_beckmann);
            color left = color(1.0);
            color fresnel;
            inner = outer;
            for (int j = 0; j <= depth; ++j) {
                fresnel = interface_reflectance(sensitivity, film_nm[j], film_ior[j], inner.cos_h, n[j], n[j + 1]);
                if (j < depth)
                    left *= cross_both_ways(1.0 - fresnel, n[j + 1], alpha[j], beckmann[j], tau[j], outer, inner);
            }
            component += weight * inner_masking(outer, inner, lobe_alpha, lobe_beckmann) * left * fresnel;
        }
    }
    return component / max(closure_energy, 1e-20);
}
