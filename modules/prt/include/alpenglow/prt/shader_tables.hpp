// What shaders/alpenglow/transfer.glsl reads beside a table's blocks.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::prt {

// The light as a shader multiplies it with stored values: 8-bit tables' scales folded in. light: in the object's frame,
// order^2 values; out: as many as the table and the light both have, which is returned.
std::size_t shader_light(const TransferTable& table, std::span<const glm::vec3> light,
                         std::span<glm::vec3> out) noexcept;

// CPCA: the light through each cluster's mean and components, [cluster][1 + components]. Once a frame, at a cost that
// does not grow with the points. out: clusters * (1 + components) values.
void light_clusters(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept;

// CPCA: slot and cluster of each point, for vertex attributes.
[[nodiscard]] std::vector<glm::uvec2> vertex_slots(const TransferTable& table);

} // namespace alpenglow::prt
