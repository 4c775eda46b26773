// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Alpha outside, along one axis, of a lobe of mean width `lobe_alpha` from a surface of mean width `alpha` in a medium of
// index n. `stretch` is the surface's own width along the axis over its mean; the rest of the lobe's width has no direction.
float anisotropic_alpha(float lobe_alpha, float alpha, float stretch, float n, float view_z)
{
    float inner_z = sqrt(max(1.0 - (1.0 - view_z * view_z) / (n * n), 0.0));
    float own = n * inner_z * alpha / (view_z * max(lobe_alpha, 1e-12));
    float share = clamp(own * own, 0.0, 1.0);
    return min(lobe_alpha * sqrt(1.0 - share + share * stretch * stretch), 1.0);
}
