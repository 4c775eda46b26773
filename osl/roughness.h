// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
float alpha_from_roughness(float roughness)
{
    return roughness * roughness;
}
