// Packing of render_data.hpp's Vertex.
#pragma once

#include "horizon.hpp"

#include "render_data.hpp"

#include <glm/common.hpp>

#include <cmath>

namespace alpenglow::sandbox {

// xyz as snorm8, x in the lowest byte.
[[nodiscard]] inline std::uint32_t pack_normal(glm::vec3 n) {
    std::uint32_t packed = 0;
    for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::int32_t>(std::lround(glm::clamp(n[k], -1.0F, 1.0F) * 127.0F));
        packed |= (static_cast<std::uint32_t>(v) & 0xFFU) << static_cast<unsigned>(8 * k);
    }
    return packed;
}

[[nodiscard]] inline glm::vec3 unpack_normal(std::uint32_t packed) {
    glm::vec3 n;
    for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::int8_t>(packed >> static_cast<unsigned>(8 * k) & 0xFFU);
        n[k] = static_cast<float>(v) / 127.0F;
    }
    return n;
}

// Reflectance by its square root, and sky visibility as it is, in 8 bits each.
[[nodiscard]] inline std::uint32_t pack_albedo(glm::vec3 albedo, float visibility) {
    std::uint32_t packed = 0;
    for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::uint32_t>(std::lround(255.0F * std::sqrt(glm::clamp(albedo[k], 0.0F, 1.0F))));
        packed |= v << static_cast<unsigned>(8 * k);
    }
    return packed | static_cast<std::uint32_t>(std::lround(255.0F * glm::clamp(visibility, 0.0F, 1.0F))) << 24U;
}

[[nodiscard]] inline glm::vec3 unpack_albedo(std::uint32_t packed) {
    glm::vec3 albedo;
    for (int k = 0; k < 3; ++k) {
        const float v = static_cast<float>(packed >> static_cast<unsigned>(8 * k) & 0xFFU) / 255.0F;
        albedo[k] = v * v;
    }
    return albedo;
}

} // namespace alpenglow::sandbox
