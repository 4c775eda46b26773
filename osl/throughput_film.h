// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "crossing.h"
#include "film.h"
// What the first `depth` interfaces, which may carry films, leave of light, and its directions below them.
color throughput(int depth, float n[], float alpha[], int beckmann[], color tau[], float sensitivity[], float film_nm[], float film_ior[], Passage outer,
                 output Passage inner)
{
    color left = color(1.0);
    inner = outer;
    for (int j = 0; j < depth; ++j) {
        color t12 = 1.0 - interface_reflectance(sensitivity, film_nm[j], film_ior[j], inner.cos_h, n[j], n[j + 1]);
        left *= cross_both_ways(t12, n[j + 1], alpha[j], beckmann[j], tau[j], outer, inner);
    }
    return left;
}
