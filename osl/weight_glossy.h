// SPDX-License-Identifier: GPL-3.0-or-later
// Weight of a microfacet closure below `depth` interfaces: the component's energy over the closure's own, averaged
// over fixed facet normals of density D cos(h).
color weight_glossy(int depth, float lobe_alpha, int lobe_beckmann, float n[], float alpha[], int beckmann[],
                    color tau[], @FILM_PARAMETERS@float view_z@FRESNEL_PARAMETERS@)
{
@NODES@
    float view_sin = sqrt(max(1.0 - view_z * view_z, 0.0));
    color component = color(0.0);
    float closure_energy = 0.0;
    for (int s = 0; s < @NODE_COUNT@; ++s) {
        float u = node_u[s];
        float tan2 = lobe_alpha * lobe_alpha * (lobe_beckmann ? -log(1.0 - u) : u / (1.0 - u));
        float z_h = 1.0 / sqrt(1.0 + tan2);
        float cos_h = z_h * (view_z + sqrt(tan2) * node_cos_phi[s] * view_sin);
        float z_i = 2.0 * cos_h * z_h - view_z;
        if (cos_h > 0.0 && z_i > 0.0) {
            float weight = node_weight[s] * cos_h / z_h;
            closure_energy += weight * masking_g2(z_i, view_z, lobe_alpha, lobe_beckmann);
            float inner_h = cos_h;
            float inner_i = z_i;
            float inner_o = view_z;
            color carried = carried_through(depth, n, alpha, beckmann, tau, @FILM_ARGUMENTS@z_h, inner_h, inner_i, inner_o);
            float inner = masking_g2(inner_i, inner_o, lobe_alpha, lobe_beckmann) * z_i * view_z / (inner_i * inner_o);
            component += weight * inner * carried * @FRESNEL@;
        }
    }
    return component / max(closure_energy, 1e-20);
}
