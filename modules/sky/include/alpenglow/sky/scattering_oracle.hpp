// The oracle of the scattering atmosphere, all orders: successive orders of scattering in double precision (course
// 2003, I^1, I^2, ...), slow. The path tracer of scattering.hpp is its independent check.
#pragma once

#include <alpenglow/sky/scattering.hpp>

#include <memory>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

struct OracleResolution {
    int heights = 33, zeniths = 16, azimuths = 14, orders = 8, bands = 18; // bands 3 .. 20
    int angles = 64;          // sun angles around the one asked for, a multiple of 16
    double step_rad = 0.0087; // between them
};

class ScatteringOracle {
public:
    // Solves the field around one zenith angle of the sun. Seconds.
    ScatteringOracle(const ScatteringAtmosphere& air, double sun_zenith_rad, const OracleResolution& resolution = {});
    ~ScatteringOracle();
    ScatteringOracle(ScatteringOracle&&) noexcept;

    // Radiance in cd/m^2 towards cosine mu to the zenith and an azimuth from the sun, by `steps` steps along the ray.
    [[nodiscard]] glm::dvec3 radiance(double height_km, double mu, double azimuth_rad, int steps = 300) const;

    // Irradiance of level ground by sun and sky, and what the ground, the air and space take of the light that falls on
    // a level plane at the top, where the shell is flat (a ground radius that makes it so): fractions by channel.
    [[nodiscard]] glm::dvec3 ground_illuminance_lux() const;
    struct Balance {
        glm::dvec3 ground, air, space;
    };
    [[nodiscard]] Balance flat_balance() const;

private:
    struct Field;
    std::unique_ptr<Field> field_;
};

} // namespace alpenglow::sky
