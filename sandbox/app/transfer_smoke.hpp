// A plume of smoke that shades itself: its density, and how it looks from the camera.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/prt/bake_volume.hpp>

#include "sandbox/world/transfer_render_data.hpp"

namespace alpenglow::sandbox {

// Rises from z = 0 at the origin, drifts towards +X and spreads. About `cell_m` between grid points.
[[nodiscard]] prt::VolumeDensity make_plume(float cell_m);

inline constexpr float smoke_albedo = 0.8F; // of single scattering

// Marches from the camera through a grid of points on a plane that faces it, `columns` x `rows` over the volume, and
// writes what the smoke sends there and covers, by vertex; triangles where anything shows. `fluence`: mean radiance
// that arrives at each grid point, cd/m^2, as update_transfer leaves it. `position_m`: of the volume's frame in the
// world.
void draw_smoke(const prt::VolumeDensity& density, std::span<const glm::vec3> fluence, const glm::vec3& position_m,
                const glm::vec3& camera_m, int columns, int rows, std::vector<SmokeVertex>& vertices,
                std::vector<std::uint32_t>& indices);

} // namespace alpenglow::sandbox
