// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "masking.h"
// Light on its way through interfaces that all share the outer half vector: cosines of that and the normal (z_h), of the
// directions and it (cos_h), of the light (z_i) and the view (z_o) and the normal, in the medium where they are.
struct Passage {
    float z_h;
    float cos_h;
    float z_i;
    float z_o;
};

// What T12 a t of Weidlich and Wilkie 2007 (eq. 2) leaves of light that crosses an interface of transmittance t12 into index n and
// the medium below, in and out. The inner directions have a closed form: w_k = w / n_k + (cos_h_k - cos_h / n_k) h.
color cross_both_ways(color t12, float n, float alpha, int beckmann, color tau, Passage outer, output Passage here)
{
    float g = masking_g2(here.z_i, here.z_o, alpha, beckmann);
    here.cos_h = sqrt(max(1.0 - (1.0 - outer.cos_h * outer.cos_h) / (n * n), 0.0));
    float shift = (here.cos_h - outer.cos_h / n) * outer.z_h;
    here.z_i = outer.z_i / n + shift;
    here.z_o = outer.z_o / n + shift;
    int blocked = here.z_i <= 0.0 || here.z_o <= 0.0;
    here.z_i = blocked ? 1.0 : here.z_i;
    here.z_o = blocked ? 1.0 : here.z_o;
    return blocked ? color(0.0) : t12 * ((1.0 - g) + t12 * g) * exp(-tau * (1.0 / here.z_i + 1.0 / here.z_o));
}
