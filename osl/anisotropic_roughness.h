// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "break_isotropy.h"
#include "roughness.h"
// Alphas along the tangent and across, and that of the isotropic surface that stands for both where only energies count.
// Blender's convention; Cycles, too, takes no alpha above 1. A slight difference stays, see break_isotropy().
void anisotropic_alphas(float roughness, float anisotropy, output float alpha_x, output float alpha_y, output float alpha)
{
    float aspect = sqrt(1.0 - 0.9 * clamp(anisotropy, 0.0, 1.0));
    alpha_x = min(break_isotropy(alpha_from_roughness(roughness)) / aspect, 1.0);
    alpha_y = alpha_from_roughness(roughness) * aspect;
    alpha = sqrt(0.5 * (alpha_x * alpha_x + alpha_y * alpha_y));
}
