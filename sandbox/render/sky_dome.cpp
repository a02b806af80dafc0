#include "sandbox/render/sky_dome.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Elevations of the rings above: equal shares of a density that peaks at the horizon and at the light.
std::array<float, SkyDome::rings> ring_elevations(float light_elevation, float horizon) {
    constexpr int kSteps = 1024;
    const float range = kPi / 2.0F - horizon;
    std::array<float, kSteps + 1> share{};
    for (int i = 0; i < kSteps; ++i) {
        const float over = (static_cast<float>(i) + 0.5F) / kSteps * range;
        const float off_light = (horizon + over - light_elevation) / 0.12F;
        const float density = 1.0F + 5.0F * std::exp(-over / 0.12F) + 8.0F * std::exp(-over / 0.02F) +
                              3.0F * std::exp(-off_light * off_light);
        share[static_cast<std::size_t>(i) + 1] = share[static_cast<std::size_t>(i)] + density;
    }
    std::array<float, SkyDome::rings> elevations{};
    elevations[0] = horizon;
    int step = 0;
    for (std::uint32_t ring = 1; ring + 1 < SkyDome::rings; ++ring) {
        const float wanted = share[kSteps] * static_cast<float>(ring) / static_cast<float>(SkyDome::rings - 1);
        while (share[static_cast<std::size_t>(step) + 1] < wanted) {
            ++step;
        }
        const float below = share[static_cast<std::size_t>(step)];
        const float part = (wanted - below) / (share[static_cast<std::size_t>(step) + 1] - below);
        elevations[ring] = horizon + (static_cast<float>(step) + part) / kSteps * range;
    }
    elevations[SkyDome::rings - 1] = kPi / 2.0F;
    return elevations;
}

// Of the rings below, from the horizon down: from the sky to the ground at once, then through the haze over it.
constexpr std::array<float, SkyDome::rings_below - 1> kBelow{0.003F, 0.02F, 0.07F, 0.22F, 0.6F};

} // namespace

float sky_azimuth_from_light(std::uint32_t i) {
    // A cubic: 0.4 of the mean spacing at the light, 2.2 of it opposite.
    const float u = 2.0F * static_cast<float>(i) / static_cast<float>(SkyDome::azimuths) - 1.0F;
    return kPi * u * (0.4F + 0.6F * u * u);
}

void place_sky_vertices(glm::vec3 to_light, float horizon_rad, std::span<SkyVertex> vertices) {
    assert(vertices.size() == SkyDome::vertices && horizon_rad <= 0.0F && horizon_rad >= -0.5F);
    const std::array<float, SkyDome::rings> above =
        ring_elevations(std::atan2(to_light.z, std::hypot(to_light.x, to_light.y)), horizon_rad);
    std::array<float, SkyDome::rings + SkyDome::rings_below> elevations{};
    std::copy(above.begin(), above.end(), elevations.begin());
    for (std::size_t ring = 0; ring < kBelow.size(); ++ring) {
        elevations[SkyDome::rings + ring] = horizon_rad - kBelow[ring];
    }
    elevations.back() = -kPi / 2.0F;
    const float light_azimuth =
        std::atan2(to_light.x, to_light.y); // atan2(0, 0) is 0: any azimuth serves at the zenith
    for (std::uint32_t i = 0; i < SkyDome::azimuths; ++i) {
        const float azimuth = light_azimuth + sky_azimuth_from_light(i);
        for (std::uint32_t ring = 0; ring < elevations.size(); ++ring) {
            const bool pole = ring + 1 == SkyDome::rings || ring + 1 == elevations.size();
            const float level = pole ? 0.0F : std::cos(elevations[ring]);
            vertices[ring * SkyDome::azimuths + i].direction = {level * std::sin(azimuth), level * std::cos(azimuth),
                                                                std::sin(elevations[ring])};
        }
    }
}

namespace {

constexpr std::uint32_t n = SkyDome::azimuths;
constexpr std::uint32_t zenith = SkyDome::vertices_above - n; // first vertices of the rings that are one point
constexpr std::uint32_t nadir = SkyDome::vertices - n;
constexpr std::uint32_t patch_azimuths = 8; // cells of a patch
constexpr std::uint32_t patch_rings = 8;
static_assert(n % patch_azimuths == 0 && (SkyDome::rings - 1) % patch_rings == 0);

// Calls fn(first vertex of the lower ring, of the upper ring, azimuth) for each cell, patch by patch, and end() after
// each patch.
template <class Cell, class End>
void for_each_cell(Cell cell, End end) {
    for (std::uint32_t azimuth = 0; azimuth < n; azimuth += patch_azimuths) {
        const auto strip = [&](std::uint32_t lower, std::uint32_t upper) {
            for (std::uint32_t i = azimuth; i < azimuth + patch_azimuths; ++i) {
                cell(lower, upper, i);
            }
        };
        for (std::uint32_t ring = SkyDome::rings_below; ring > 1; --ring) {
            strip(SkyDome::vertices_above + (ring - 1) * n, SkyDome::vertices_above + (ring - 2) * n);
        }
        end();
        strip(SkyDome::vertices_above, 0);
        for (std::uint32_t ring = 0; ring + 1 < SkyDome::rings; ++ring) {
            strip(ring * n, (ring + 1) * n);
            if ((ring + 1) % patch_rings == 0) {
                end();
            }
        }
    }
}

} // namespace

std::vector<std::uint32_t> sky_dome_indices() {
    std::vector<std::uint32_t> indices;
    for_each_cell(
        [&indices](std::uint32_t lower, std::uint32_t upper, std::uint32_t i) {
            const std::uint32_t next = (i + 1) % n;
            if (lower != nadir) {
                indices.insert(indices.end(), {lower + i, upper + next, lower + next});
            }
            if (upper != zenith) {
                indices.insert(indices.end(), {lower + i, upper + i, upper + next});
            }
        },
        [] {});
    return indices;
}

std::vector<SkyPatch> sky_dome_patches() {
    std::vector<SkyPatch> patches;
    SkyPatch patch;
    for_each_cell(
        [&patch](std::uint32_t lower, std::uint32_t upper, std::uint32_t i) {
            const std::uint32_t next = (i + 1) % n;
            patch.index_count += (lower != nadir ? 3U : 0U) + (upper != zenith ? 3U : 0U);
            patch.corners.insert(patch.corners.end(), {lower + i, lower + next, upper + i, upper + next});
        },
        [&] {
            std::sort(patch.corners.begin(), patch.corners.end());
            patch.corners.erase(std::unique(patch.corners.begin(), patch.corners.end()), patch.corners.end());
            patches.push_back(patch);
            patch = {patch.first_index + patch.index_count, 0, {}};
        });
    return patches;
}

std::vector<IndexRun> visible_sky(std::span<const SkyPatch> patches, std::span<const SkyVertex> vertices,
                                  std::span<const glm::vec3, 4> side_planes) {
    std::vector<IndexRun> runs;
    for (const SkyPatch& patch : patches) {
        // Out of sight if all corners lie outside of one plane: then so does all between them.
        const bool hidden = std::any_of(side_planes.begin(), side_planes.end(), [&](const glm::vec3& plane) {
            return std::all_of(patch.corners.begin(), patch.corners.end(), [&](std::uint32_t corner) {
                return glm::dot(plane, vertices[corner].direction) < 0.0F;
            });
        });
        if (hidden) {
            continue;
        }
        if (!runs.empty() && runs.back().first + runs.back().count == patch.first_index) {
            runs.back().count += patch.index_count;
        } else {
            runs.push_back({patch.first_index, patch.index_count});
        }
    }
    return runs;
}

} // namespace alpenglow::sandbox
