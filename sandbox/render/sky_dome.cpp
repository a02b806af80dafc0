#include "sandbox/render/sky_dome.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Elevations of the rings: equal shares of a density that peaks at the horizon and at the sun.
std::array<float, SkyDome::rings> ring_elevations(float sun_elevation) {
    constexpr int kSteps = 512;
    std::array<float, kSteps + 1> share{};
    for (int i = 0; i < kSteps; ++i) {
        const float elevation = (static_cast<float>(i) + 0.5F) / kSteps * kPi / 2.0F;
        const float off_sun = (elevation - sun_elevation) / 0.12F;
        const float density = 1.0F + 5.0F * std::exp(-elevation / 0.12F) + 3.0F * std::exp(-off_sun * off_sun);
        share[static_cast<std::size_t>(i) + 1] = share[static_cast<std::size_t>(i)] + density;
    }
    std::array<float, SkyDome::rings> elevations{};
    int step = 0;
    for (std::uint32_t ring = 1; ring + 1 < SkyDome::rings; ++ring) {
        const float wanted = share[kSteps] * static_cast<float>(ring) / static_cast<float>(SkyDome::rings - 1);
        while (share[static_cast<std::size_t>(step) + 1] < wanted) {
            ++step;
        }
        const float below = share[static_cast<std::size_t>(step)];
        const float part = (wanted - below) / (share[static_cast<std::size_t>(step) + 1] - below);
        elevations[ring] = (static_cast<float>(step) + part) / kSteps * kPi / 2.0F;
    }
    elevations[SkyDome::rings - 1] = kPi / 2.0F;
    return elevations;
}

} // namespace

float sky_azimuth_from_sun(std::uint32_t i) {
    // A cubic: 0.4 of the mean spacing at the sun, 2.2 of it opposite.
    const float u = 2.0F * static_cast<float>(i) / static_cast<float>(SkyDome::azimuths) - 1.0F;
    return kPi * u * (0.4F + 0.6F * u * u);
}

void place_sky_vertices(glm::vec3 to_sun, std::span<SkyVertex> vertices) {
    assert(vertices.size() == SkyDome::vertices);
    const std::array<float, SkyDome::rings> elevations =
        ring_elevations(std::atan2(to_sun.z, std::hypot(to_sun.x, to_sun.y)));
    const float sun_azimuth = std::atan2(to_sun.x, to_sun.y); // atan2(0, 0) is 0: any azimuth serves at the zenith
    for (std::uint32_t i = 0; i < SkyDome::azimuths; ++i) {
        const float azimuth = sun_azimuth + sky_azimuth_from_sun(i);
        for (std::uint32_t ring = 0; ring < SkyDome::rings; ++ring) {
            const float level = ring + 1 == SkyDome::rings ? 0.0F : std::cos(elevations[ring]);
            vertices[ring * SkyDome::azimuths + i].direction = {level * std::sin(azimuth), level * std::cos(azimuth),
                                                                std::sin(elevations[ring])};
        }
    }
}

std::vector<std::uint32_t> sky_dome_indices() {
    constexpr std::uint32_t n = SkyDome::azimuths;
    constexpr std::uint32_t zenith = SkyDome::vertices - n; // rings that are one point
    constexpr std::uint32_t nadir = SkyDome::vertices + n;
    std::vector<std::uint32_t> indices;
    const auto strip = [&](std::uint32_t lower, std::uint32_t upper) { // first vertices of two rings
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t next = (i + 1) % n;
            if (lower != nadir) {
                indices.insert(indices.end(), {lower + i, upper + next, lower + next});
            }
            if (upper != zenith) {
                indices.insert(indices.end(), {lower + i, upper + i, upper + next});
            }
        }
    };
    for (std::uint32_t ring = 0; ring + 1 < SkyDome::rings; ++ring) {
        strip(ring * n, (ring + 1) * n);
    }
    strip(SkyDome::vertices, 0);
    strip(nadir, SkyDome::vertices);
    return indices;
}

} // namespace alpenglow::sandbox
