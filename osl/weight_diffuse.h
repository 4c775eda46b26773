// SPDX-License-Identifier: GPL-3.0-or-later
// Angular part of a diffuse lobe: 1 for Lambert (sigma 0), Oren and Nayar's otherwise.
float diffuse_lobe(float cos_io, float z_i, float z_o, float sigma)
{
    float t = cos_io - z_i * z_o;
    return 1.0 + sigma * (t > 0.0 ? t / max(z_i, z_o) : t);
}

// What `depth` interfaces leave of a diffuse base's energy, averaged over fixed light directions of cosine density.
color weight_diffuse(int depth, float n[], float alpha[], int beckmann[], color tau[], @FILM_PARAMETERS@float view_z, float sigma)
{
@NODES@
    float view_sin = sqrt(max(1.0 - view_z * view_z, 0.0));
    color component = color(0.0);
    float closure_energy = 0.0;
    for (int s = 0; s < @NODE_COUNT@; ++s) {
        float z_i = sqrt(node_u[s]);
        float cos_io = z_i * view_z + sqrt(1.0 - node_u[s]) * node_cos_phi[s] * view_sin;
        closure_energy += node_weight[s] * diffuse_lobe(cos_io, z_i, view_z, sigma);
        float cos_h = sqrt(max(0.5 * (1.0 + cos_io), 0.0));
        float z_h = 0.5 * (z_i + view_z) / max(cos_h, 1e-6);
        float z_o = view_z;
        color carried = carried_through(depth, n, alpha, beckmann, tau, @FILM_ARGUMENTS@z_h, cos_h, z_i, z_o);
        component += node_weight[s] * carried * diffuse_lobe(2.0 * cos_h * cos_h - 1.0, z_i, z_o, sigma);
    }
    return component / closure_energy;
}
