// The sky of the scattering atmosphere from the tables of sky::SkyView and sky::AerialTable (modules/sky), for shaders.
// This file is GLSL and C++ at once: modules/sky compiles it too, so that both say the same.
//
// Sky view: upload values() as a texture of width columns() and height rows() * 4, RGB: for each row of the view four
// lines, molecules, aerosol, aureole, multiple scattering. The caller binds it and defines
// ALPENGLOW_SKY_VIEW_FETCH(column, line) -> vec3 before including this.
// Aerial table: upload light() as four three-dimensional textures of columns() x rows() x slices() and extinction() as
// one of rows() x slices(), all with linear filter, and define ALPENGLOW_AERIAL_LIGHT(column, row, slice, term) -> vec3
// and ALPENGLOW_AERIAL_EXTINCTION(row, slice) -> vec3, which take fractional places, texel centres at whole numbers.
#ifndef ALPENGLOW_SKY_VIEW_GLSL
#define ALPENGLOW_SKY_VIEW_GLSL

#include "aerial_perspective.glsl"

struct AlpenglowSkyView {
    float horizon;         // cosine of the horizon's zenith angle: SkyView::horizon()
    float mie_g;           // of the aerosol
    float mie_mean_cosine; // of its Cornette-Shanks phase function
    int rows;
    int columns;
};

struct AlpenglowAerialTable {
    float reach_km;
    float mie_g;
    float mie_mean_cosine;
    int rows;
    int columns;
    int slices;
};

float alpenglow_phase_cornette_shanks(float cosine, float g) {
    float d = (1.0F - g) * (1.0F - g) + 2.0F * g * (1.0F - cosine);
    return 0.1193662073F * (1.0F - g * g) * (1.0F + cosine * cosine) / ((2.0F + g * g) * max(d * sqrt(d), 1e-12F));
}

// Cosine of the azimuth between a direction and the sun.
float alpenglow_azimuth_cosine(vec3 direction, vec3 to_sun) {
    float level = direction.x * to_sun.x + direction.y * to_sun.y;
    float across = sqrt((direction.x * direction.x + direction.y * direction.y) *
                        (to_sun.x * to_sun.x + to_sun.y * to_sun.y));
    return across > 1e-12F ? clamp(level / across, -1.0F, 1.0F) : 1.0F;
}

// Row (fractional) of a cosine to the zenith; SkyView::row_of.
float alpenglow_sky_view_row(AlpenglowSkyView view, float mu) {
    float n = 0.5F * float(view.rows);
    if (mu >= view.horizon) {
        float t = sqrt(max(mu - view.horizon, 0.0F) / (1.0F - view.horizon));
        return clamp(n - 0.5F - t * (n - 0.5F), 0.0F, n - 1.0F);
    }
    float t = sqrt(max(view.horizon - 1e-5F - mu, 0.0F) / max(1.0F + view.horizon - 1e-5F, 1e-6F));
    return clamp(n + t * (n - 1.0F), n, float(view.rows - 1));
}

#ifdef ALPENGLOW_SKY_VIEW_FETCH
vec3 alpenglow_sky_view_mix(float column, int row0, int row1, float v, int term) {
    int j = int(column);
    float u = column - float(j);
    vec3 low = mix(ALPENGLOW_SKY_VIEW_FETCH(j, row0 * 4 + term), ALPENGLOW_SKY_VIEW_FETCH(j + 1, row0 * 4 + term), u);
    vec3 high = mix(ALPENGLOW_SKY_VIEW_FETCH(j, row1 * 4 + term), ALPENGLOW_SKY_VIEW_FETCH(j + 1, row1 * 4 + term), u);
    return mix(low, high, v);
}

// Radiance towards a unit direction of the local frame (z up), cd/m^2, without the sun's disc; SkyView::radiance.
vec3 alpenglow_sky_view(AlpenglowSkyView view, vec3 direction, vec3 to_sun) {
    float nu = clamp(dot(direction, to_sun), -1.0F, 1.0F);
    float mu = clamp(direction.z, -1.0F, 1.0F);
    float angle = acos(alpenglow_azimuth_cosine(direction, to_sun));
    float column = min(angle * 0.318309886F * float(view.columns - 1), float(view.columns - 1) - 1e-3F);
    float row = alpenglow_sky_view_row(view, mu);
    int last = mu >= view.horizon ? view.rows / 2 - 1 : view.rows - 1;
    int row0 = min(int(row), last);
    int row1 = min(row0 + 1, last);
    float v = row - float(row0);
    float g2 = view.mie_mean_cosine * view.mie_mean_cosine;
    vec3 sum = alpenglow_phase_rayleigh(nu) * alpenglow_sky_view_mix(column, row0, row1, v, 0);
    sum += alpenglow_phase_cornette_shanks(nu, view.mie_g) * alpenglow_sky_view_mix(column, row0, row1, v, 1);
    sum += alpenglow_phase_henyey_greenstein(nu, g2) * alpenglow_sky_view_mix(column, row0, row1, v, 2);
    return max(sum + alpenglow_sky_view_mix(column, row0, row1, v, 3), vec3(0.0F));
}
#endif

#ifdef ALPENGLOW_AERIAL_LIGHT
// What the air takes and adds over a distance towards a unit direction of the local frame; AerialTable::evaluate.
AlpenglowAerial alpenglow_aerial_table(AlpenglowAerialTable table, vec3 direction, float distance_km, vec3 to_sun) {
    float nu = clamp(dot(direction, to_sun), -1.0F, 1.0F);
    float mu = clamp(direction.z, -1.0F, 1.0F);
    float held = clamp(distance_km, 0.0F, table.reach_km);
    float column = acos(alpenglow_azimuth_cosine(direction, to_sun)) * 0.318309886F * float(table.columns - 1);
    float root = mu >= 0.0F ? sqrt(mu) : -sqrt(-mu);
    float row = (0.5F + 0.5F * root) * float(table.rows - 1);
    float slice = sqrt(held / table.reach_km) * float(table.slices - 1);
    float g2 = table.mie_mean_cosine * table.mie_mean_cosine;
    vec3 sum = alpenglow_phase_rayleigh(nu) * ALPENGLOW_AERIAL_LIGHT(column, row, slice, 0);
    sum += alpenglow_phase_cornette_shanks(nu, table.mie_g) * ALPENGLOW_AERIAL_LIGHT(column, row, slice, 1);
    sum += alpenglow_phase_henyey_greenstein(nu, g2) * ALPENGLOW_AERIAL_LIGHT(column, row, slice, 2);
    sum += ALPENGLOW_AERIAL_LIGHT(column, row, slice, 3);
    AlpenglowAerial result;
    result.transmittance = exp(-held * ALPENGLOW_AERIAL_EXTINCTION(row, slice));
    result.in_scatter = max(held * sum, vec3(0.0F));
    return result;
}
#endif

// Brightness over the sun's disc relative to its mean: limb darkening 1 - u (1 - mu) with u = 0.6, mu the cosine on the
// sun's surface (Cox 2000, near 550 nm). `angle` from the disc's centre over its radius, 0 .. 1.
float alpenglow_limb_darkening(float angle) {
    float mu = sqrt(max(1.0F - angle * angle, 0.0F));
    return (1.0F - 0.6F * (1.0F - mu)) * 1.25F;
}

#endif
