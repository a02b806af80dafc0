// Run time of neighbourhoods and bent normals.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::prt {

// Radiance that leaves a diffuse receiver of albedo 1 at `position_m` with unit `normal` (both in the object's frame)
// under the object's neighbourhood. `planes` is what evaluate_matrix or update_transfer wrote for the table, `light`
// the incident coefficients in the object's frame. Trilinear between grid points; in the outermost cells the object's
// influence fades, and outside the grid the light arrives as it is.
[[nodiscard]] glm::vec3 sample_neighbourhood(const TransferInfo& info, std::span<const glm::vec3> planes,
                                             std::span<const glm::vec3> light, const glm::vec3& position_m,
                                             const glm::vec3& normal) noexcept;

// Ambient occlusion and the bent normal, from shadowed transfer of order 2 or more, [point]: xyz the mean unoccluded
// direction weighted by the cosine (unit, or zero where dark), w the visible part of the cosine-weighted hemisphere.
[[nodiscard]] std::vector<glm::vec4> bent_normals(const TransferField& field);

} // namespace alpenglow::prt
