// What run time reads of a scattering atmosphere: the sun's light at every height, multiple scattering, and the sky as
// seen from a place. Built on the CPU with the widest SIMD at hand, single precision.
//
// In the spirit of Bruneton and Neyret 2008 and Hillaire 2020, with other means (docs/sky.md): multiple scattering is
// solved by successive orders along rays of constant impact parameter and keeps the direction of the light, 14 bands of
// spherical harmonics at each height and sun angle; what those bands cannot hold has terms of its own: the sun's
// aureole, and the share of the aerosol's scattering that goes straight on (delta-M, Wiscombe 1977).
#pragma once

#include <alpenglow/sky/scattering.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

struct ScatteringResolution {
    int sun_heights = 128, sun_angles = 160; // the sun's light (transmittance)
    int field_heights = 33;                  // multiple scattering: shells
    int field_zeniths = 12;                  // rays to the ground
    int field_azimuths = 12;                 // over half a circle, up to 16
    int field_orders = 4;                    // gathered; the rest of the series by their ratio
    int field_bands = 14;                    // of spherical harmonics, 3 to 20
};

// The sun's light at heights h = top t^2 by angles w = sqrt(mu_s - mu_horizon): columns of air up to the top.
inline constexpr float sun_axis_high = 1.4143F;

struct ScatteredZones;

class ScatteringTables {
public:
    explicit ScatteringTables(const ScatteringAtmosphere& air, const ScatteringResolution& resolution = {});

    [[nodiscard]] const ScatteringAtmosphere& air() const { return air_; }
    [[nodiscard]] const ScatteringResolution& resolution() const { return resolution_; }

    // Columns of molecules, aerosol and ozone on the way to the sun, km of their density at sea level (ozone: of its
    // most): [height][3][angle].
    [[nodiscard]] std::span<const float> sun() const { return sun_; }
    // The scattered light, on two grids of sun angles (the day's, 4 degrees apart, and twilight's, half a degree).
    [[nodiscard]] const ScatteredZones& field() const { return *field_; }
    [[nodiscard]] std::size_t field_bytes() const;

    // The sun's light at a height relative to outside: with the visible part of its disc.
    [[nodiscard]] glm::vec3 sun_transmittance(float height_km, float mu_s) const;
    // Transmittance from a height towards a cosine to the zenith, out of the air; rays that meet the ground count as
    // grazing it.
    [[nodiscard]] glm::vec3 transmittance(float height_km, float mu) const;
    // Irradiance of level ground, sun and sky, in lux.
    [[nodiscard]] glm::vec3 ground_illuminance_lux(float mu_s) const;

    // Rebuilds a part, for the benchmark.
    void build_sun();
    void build_field();

private:
    [[nodiscard]] glm::vec3 columns(float height_km, float mu) const;

    ScatteringAtmosphere air_;
    ScatteringResolution resolution_;
    std::vector<float> sun_;
    std::shared_ptr<const ScatteredZones> field_;
};

inline constexpr int sky_view_values = 12;

// The sky from one height for one sun: rows of zenith angle by columns of azimuth from the sun, 0 .. pi (the other half
// mirrors it). Over the horizon and under it rows crowd towards the horizon, by a square law.
class SkyView {
public:
    explicit SkyView(int rows = 108, int columns = 97) : rows_(rows), columns_(columns) {}

    // The sun need not be up. `steps` a ray, 128 at most.
    void build(const ScatteringTables& tables, float height_km, float mu_s, int steps = 48);

    // Radiance in cd/m^2 towards a direction of the local frame, without the sun's disc.
    [[nodiscard]] glm::vec3 radiance(const glm::vec3& direction, const glm::vec3& to_sun) const;

    [[nodiscard]] int rows() const { return rows_; }
    [[nodiscard]] int columns() const { return columns_; }
    // [row][sky_view_values][column], R, G, B each: molecules, aerosol, aureole scattered again (these three without
    // their phase functions: Rayleigh, Cornette-Shanks, Henyey-Greenstein of the square of its mean cosine), multiple
    // scattering; cd/m^2.
    [[nodiscard]] std::span<const float> values() const { return values_; }
    [[nodiscard]] float horizon() const { return horizon_; } // cosine of its zenith angle
    [[nodiscard]] float mie_g() const { return mie_g_; }
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
