// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "crossing.h"
#include "fresnel_dielectric.h"
// What the first `depth` interfaces leave of light, and its directions below them.
color throughput(int depth, float n[], float alpha[], int beckmann[], color tau[], Passage outer,
                 output Passage inner)
{
    color left = color(1.0);
    inner = outer;
    for (int j = 0; j < depth; ++j) {
        float t12 = 1.0 - fresnel_dielectric(inner.cos_h, n[j + 1] / n[j]);
        left *= cross_both_ways(t12, n[j + 1], alpha[j], beckmann[j], tau[j], outer, inner);
    }
    return left;
}
