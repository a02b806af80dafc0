// What the sky's two benchmark files share.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::bench {

// Directions spread evenly over the upper hemisphere (Fibonacci).
inline std::vector<glm::vec3> hemisphere(std::size_t count) {
    std::vector<glm::vec3> out;
    for (std::size_t i = 0; i < count; ++i) {
        const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const double a = 2.399963229728653 * static_cast<double>(i);
        const double r = std::sqrt(1.0 - z * z);
        out.emplace_back(glm::dvec3(r * std::cos(a), r * std::sin(a), z));
    }
    return out;
}

inline double relative(const glm::dvec3& got, const glm::dvec3& want) {
    return glm::length(got - want) / glm::length(want);
}

} // namespace alpenglow::bench
