// The light that has been scattered: successive orders on a grid of heights and sun angles, directions as spherical
// harmonics. Single precision and few nodes for run time, double and many for the oracle.
#pragma once

#include <alpenglow/sky/scattering.hpp>

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace alpenglow::sky {

inline constexpr int most_field_bands = 20;
inline constexpr std::size_t most_field_functions = 210; // (l, m >= 0), l (l + 1) / 2 + m

struct FieldResolution {
    int heights = 33;                      // shells, by a square law
    int zeniths = 12;                      // rays that meet the ground, from above and from below
    int azimuths = 12;                     // over half a circle, 16 at most
    int orders = 4;                        // gathered; the rest by the ratio of the last two
    int bands = 10;                        // of spherical harmonics, 3 to 20
    int late_bands = 8, late_azimuths = 8; // from the third order on
    int all_tangents = 9;                  // shells with a ray that touches them; above, every second
};

// Uniform zenith angles of the sun, count a multiple of 16.
struct FieldAngles {
    double low_rad, step_rad;
    int count;
};

template <class T>
struct ScatteredField {
    FieldAngles angles{};
    int heights = 0, bands = 0;
    std::array<double, most_field_bands> phase_bands{}; // of Cornette-Shanks: integral of phase times P_l
    double forward = 0.0; // the next band: the share of aerosol's scattering taken as going straight on
    // All over the sun's light outside the air. Light from all around, but for the aureole: [height][function][channel]
    // [angle], integrals of radiance times Y_lm, functions in the order of field_function(); aureole: strength of the
    // light that aerosol scattered once on the sun's ray, whose phase function is Cornette-Shanks:
    // [height][channel][angle]; ground: irradiance of level ground, sun and sky: [channel][angle]; sun: its light at
    // the shells [height][channel][angle].
    std::vector<T> field, aureole, ground, sun;
};

// Impact parameters instead of directions: a ray keeps its distance from the Earth's centre, so that it meets every
// shell in directions that other shells know of, and light is carried from shell to shell without interpolating
// directions. The sun's angle moves along a ray: by -alpha cos(azimuth) for an angle alpha at the Earth's centre, which
// is a shift on the grid of sun angles (exact to alpha^2 cot(theta_s) / 2).
// The sun's light relative to outside at a height, for a zenith angle of the sun; and the scattering depth of the
// aerosol on its way.
using SunAt = std::function<void(double height_km, double sun_zenith_rad, glm::dvec3& light, glm::dvec3& depth)>;

template <class T>
void build_scattered_field(const ScatteringAtmosphere& air, const FieldResolution& resolution,
                           std::span<const FieldAngles> angles, const SunAt& sun_at, std::span<ScatteredField<T>> out);

// In double precision by quadrature, for the oracle.
void exact_sun_at(const ScatteringAtmosphere& air, double height_km, double sun_zenith_rad, glm::dvec3& light,
                  glm::dvec3& depth);

// Where a function stands in a field.
inline std::size_t field_function(int bands, std::size_t l, std::size_t m) {
    return m * (2 * static_cast<std::size_t>(bands) - m + 1) / 2 + l - m;
}

// Y_lm without the cosine of the azimuth: [l (l + 1) / 2 + m] for a cosine z and sine s (signed) of the zenith angle.
void field_shapes(int bands, double z, double s, std::span<double> out);
// Integrals of Cornette-Shanks times P_l, l = 0 .. bands.
void cornette_shanks_bands(double g, int bands, std::span<double> out);

struct ScatteredZones {
    std::array<ScatteredField<float>, 2> zones; // the day's and twilight's
    [[nodiscard]] const ScatteredField<float>& at(double sun_zenith_rad) const {
        return zones[sun_zenith_rad < 1.4 ? 0 : 1]; // 80 degrees
    }
};

} // namespace alpenglow::sky
