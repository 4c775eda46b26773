// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "film.h"
#include "fresnel_conductor.h"
// Reflectance of a metal that may carry a film, all indices absolute.
color metal_reflectance(float sensitivity[], float film_nm, float film_ior, float cos_theta_i, float n_above, color eta, color k)
{
    if (film_nm <= FILM_THINNEST)
        return fresnel_conductor(cos_theta_i, eta / n_above, k / n_above);
    return film_reflectance(sensitivity, film_nm, film_ior, cos_theta_i, n_above, eta, k);
}
