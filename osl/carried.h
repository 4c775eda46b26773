// SPDX-License-Identifier: GPL-3.0-or-later
// What T12 a t of Weidlich and Wilkie 2007 (eq. 2) leaves of light that crosses the first `depth` interfaces on its way in
// and out. All interfaces share the outer half vector, so the inner directions have a closed form:
// w_k = w / n_k + (cos_h_k - cos_h / n_k) h. Cosines z_i and z_o and cos_h are replaced by the inner ones.
color carried_through(int depth, float n[], float alpha[], int beckmann[], color tau[], @FILM_PARAMETERS@float z_h,
                      output float cos_h, output float z_i, output float z_o)
{
    color carried = color(1.0);
    float outer_h = cos_h;
    float outer_i = z_i;
    float outer_o = z_o;
    for (int j = 0; j < depth; ++j) {
        @T12@
        float g = masking_g2(z_i, z_o, alpha[j], beckmann[j]);
        cos_h = sqrt(max(1.0 - (1.0 - outer_h * outer_h) / (n[j + 1] * n[j + 1]), 0.0));
        float shift = (cos_h - outer_h / n[j + 1]) * z_h;
        z_i = outer_i / n[j + 1] + shift;
        z_o = outer_o / n[j + 1] + shift;
        if (z_i <= 0.0 || z_o <= 0.0) {
            z_i = z_o = 1.0;
            return color(0.0);
        }
        carried *= t12 * ((1.0 - g) + t12 * g) * exp(-tau[j] * (1.0 / z_i + 1.0 / z_o));
    }
    return carried;
}
