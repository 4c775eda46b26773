// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Complex index from reflectance r at normal incidence and edge tint g (Gulbrandsen 2014, eqs. 3 and 4).
void artist_index(color r, color g, output color eta, output color k)
{
    color low = (1.0 - r) / (1.0 + r);
    color high = (1.0 + sqrt(r)) / (1.0 - sqrt(r));
    eta = g * low + (1.0 - g) * high;
    color above = eta + 1.0;
    color below = eta - 1.0;
    k = sqrt(max((r * above * above - below * below) / (1.0 - r), color(0.0)));
}
