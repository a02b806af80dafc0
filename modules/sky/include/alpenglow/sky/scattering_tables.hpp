// What run time reads of a scattering atmosphere: the sun's light at every height, multiple scattering, and the sky as
// seen from a place. Built on the CPU with the widest SIMD at hand, single precision.
//
// After Bruneton and Neyret 2008 and Hillaire 2020, with changes that make it more accurate and cheaper: multiple
// scattering keeps the direction of the light (spherical harmonics of 3 bands at each height and sun angle, rather than
// one isotropic number); what those bands cannot hold, the sun's aureole, has its own term (light scattered forward
// along the sun's ray has, the second time, the phase function of mean cosine g^2); orders from the third on are solved
// as one linear system over heights and bands; and the sky keeps its terms apart, so that the phase functions are exact
// at any resolution.
#pragma once

#include <alpenglow/sky/scattering.hpp>

#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

struct ScatteringResolution {
    int sun_heights = 64, sun_angles = 128;     // the sun's light (transmittance)
    int field_heights = 24, field_angles = 48;  // multiple scattering
    int field_zeniths = 12, field_azimuths = 6; // directions gathered at each of its points
    int field_steps = 16;
};

// Axes of the tables. Heights by a square law: h = top t^2. The sun's table runs over w = signed root of mu_s -
// mu_horizon, so that the edge of the Earth's shadow lies at the same place in every row; the field's over the signed
// root of mu_s - field_centre.
inline constexpr float sun_axis_low = -0.1F;
inline constexpr float sun_axis_high = 1.4143F;
inline constexpr float field_centre = -0.1F;
inline constexpr float field_axis_low = -0.95F;
inline constexpr float field_axis_high = 1.0489F;
inline constexpr int field_functions = 6; // (0,0) (1,0) (1,1) (2,0) (2,1) (2,2) of the light from all around

class ScatteringTables {
public:
    explicit ScatteringTables(const ScatteringAtmosphere& air, const ScatteringResolution& resolution = {});

    [[nodiscard]] const ScatteringAtmosphere& air() const { return air_; }
    [[nodiscard]] const ScatteringResolution& resolution() const { return resolution_; }

    // Sun's light relative to outside: [height][9][angle]. Rows: R, G, B; then the light that aerosol has scattered
    // once on its way (times the aerosol's scattering depth d), and twice (d^2 / 2), which still comes from around the
    // sun.
    [[nodiscard]] std::span<const float> sun() const { return sun_; }
    // Radiance field that scatters again, over the sun's light outside: [height][function][channel][angle]; and the
    // sun's aureoles apart from it.
    [[nodiscard]] std::span<const float> field() const { return field_; }
    [[nodiscard]] std::span<const float> aureole() const { return aureole_; }
    // Irradiance of the ground over the sun's light outside: [channel][angle], on the field's angles.
    [[nodiscard]] std::span<const float> ground() const { return ground_; }

    // The sun's light at a height, relative to outside; bilinear.
    [[nodiscard]] glm::vec3 sun_transmittance(float height_km, float mu_s) const;
    // Irradiance of level ground, sun and sky, in lux.
    [[nodiscard]] glm::vec3 ground_illuminance_lux(float mu_s) const;

    // Rebuilds a part, for the benchmark.
    void build_sun();
    void build_field();

private:
    [[nodiscard]] glm::vec3 sun_row(float height_km, float mu_s, int kind) const;
    void add_higher_orders(const std::vector<float>& second, const std::vector<float>& second_ground);

    ScatteringAtmosphere air_;
    ScatteringResolution resolution_;
    std::vector<float> sun_, field_, aureole_, ground_;
};

inline constexpr int sky_view_values = 12;

// The sky from one height for one sun: rows of zenith angle by columns of azimuth from the sun, 0 .. pi (the other half
// mirrors it). Over the horizon and under it rows crowd towards the horizon.
class SkyView {
public:
    SkyView(int rows = 108, int columns = 24) : rows_(rows), columns_(columns) {}

    // The sun need not be up. Cost: about rows x columns x steps lookups.
    void build(const ScatteringTables& tables, float height_km, float mu_s, int steps = 32);

    // Radiance in cd/m^2 towards a direction of the local frame, without the sun's disc.
    [[nodiscard]] glm::vec3 radiance(const glm::vec3& direction, const glm::vec3& to_sun) const;

    [[nodiscard]] int rows() const { return rows_; }
    [[nodiscard]] int columns() const { return columns_; }
    // [row][sky_view_values][column], R, G, B each: molecules, aerosol, aureole scattered again (these three without
    // their phase functions: Rayleigh, Cornette-Shanks, Henyey-Greenstein of the square of its mean cosine), multiple
    // scattering; cd/m^2.
    [[nodiscard]] std::span<const float> values() const { return values_; }
    [[nodiscard]] float horizon() const { return horizon_; } // cosine of its zenith angle
    [[nodiscard]] float mie_mean_cosine() const { return mie_mean_cosine_; }
    // Cosine to the zenith of a row, and the row (fractional) of a cosine.
    [[nodiscard]] float cosine_of(float row) const;
    [[nodiscard]] float row_of(float mu) const;

private:
    int rows_, columns_;
    float horizon_ = 0.0F; // cosine of the horizon's zenith angle
    float mie_g_ = 0.8F, mie_mean_cosine_ = 0.84F;
    std::vector<float> values_;
};

} // namespace alpenglow::sky
