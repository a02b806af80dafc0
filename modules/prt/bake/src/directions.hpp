// Sets of directions, and the per-point frames that turn them.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::prt {

// A counter-based generator: value `index` of stream `seed`, uniform in [0, 1). The same for any order of calls.
[[nodiscard]] std::uint64_t mix(std::uint64_t value) noexcept;
[[nodiscard]] double uniform(std::uint64_t seed, std::uint64_t index) noexcept;

// Concentric map of the unit square to the hemisphere about +Z with density cos(theta) / pi (Shirley and Chiu 1997).
[[nodiscard]] glm::dvec3 cosine_direction(double x, double y) noexcept;

// Golden-angle spirals: equal cosine measure on the hemisphere, equal solid angle on the sphere.
[[nodiscard]] std::vector<glm::dvec3> fibonacci_hemisphere(std::size_t count);
[[nodiscard]] std::vector<glm::dvec3> fibonacci_sphere(std::size_t count);

// Columns x, y, normal, right-handed, turned about the normal by `spin_rad`.
[[nodiscard]] glm::mat3 frame_about(const glm::vec3& normal, float spin_rad) noexcept;

} // namespace alpenglow::prt
