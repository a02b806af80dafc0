#include <alpenglow/prt/neighbourhood.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/irradiance.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::prt {

glm::vec3 sample_neighbourhood(const TransferInfo& info, std::span<const glm::vec3> planes,
                               std::span<const glm::vec3> light, const glm::vec3& position_m,
                               const glm::vec3& normal) noexcept {
    assert(planes.size() >= info.rows * info.count);
    const int order = static_cast<int>(std::lround(std::sqrt(static_cast<double>(info.rows))));
    std::array<float, sh::max_coefficients> y{};
    sh::evaluate_basis(order, normal, y);
    for (int l = 0; l < order; ++l) {
        const auto factor = static_cast<float>(sh::cosine_factor(l) / pi);
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            y[static_cast<std::size_t>(i)] *= factor;
        }
    }
    glm::vec3 free(0.0F);
    for (std::size_t i = 0; i < std::min<std::size_t>(info.rows, light.size()); ++i) {
        free += y[i] * light[i];
    }
    const glm::vec3 last = glm::vec3(info.grid_size) - 1.0F;
    const glm::vec3 at = (position_m - info.grid_origin_m) / info.grid_step_m;
    // 1 inside, falling to 0 over the outermost cell.
    float inside = 1.0F;
    for (int axis = 0; axis < 3; ++axis) {
        const float edge = std::min(at[axis], last[axis] - at[axis]);
        if (!(edge >= 0.0F)) { // NaN too
            return free;
        }
        inside *= std::min(edge, 1.0F);
    }
    if (inside <= 0.0F) {
        return free;
    }
    const glm::uvec3 low = glm::min(glm::uvec3(at), glm::max(info.grid_size, glm::uvec3(2)) - 2U);
    const glm::vec3 f = at - glm::vec3(low);
    glm::vec3 lit(0.0F);
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::uvec3 c = low + glm::uvec3(corner & 1U, (corner >> 1U) & 1U, corner >> 2U);
        const float w = ((corner & 1U) != 0 ? f.x : 1.0F - f.x) * ((corner & 2U) != 0 ? f.y : 1.0F - f.y) *
                        ((corner & 4U) != 0 ? f.z : 1.0F - f.z);
        if (w == 0.0F) {
            continue;
        }
        const std::size_t point = c.x + std::size_t{info.grid_size.x} * (c.y + std::size_t{info.grid_size.y} * c.z);
        for (std::size_t i = 0; i < info.rows; ++i) {
            lit += (w * y[i]) * planes[i * info.count + point];
        }
    }
    return glm::mix(free, lit, inside);
}

std::vector<glm::vec4> bent_normals(const TransferField& field) {
    assert(field.order >= 2 && field.out_order == 0);
    const auto scale = static_cast<float>(std::sqrt(4.0 * pi));
    std::vector<glm::vec4> out(field.count);
    for (std::size_t p = 0; p < field.count; ++p) {
        const std::span<const float> m = field.point(p);
        const glm::vec3 mean(-m[3], -m[1], m[2]); // Y_1 is (-y, z, -x) times a constant
        const float length = glm::length(mean);
        const glm::vec3 direction = length > 1e-12F ? mean / length : glm::vec3(0.0F);
        out[p] = glm::vec4(direction, std::clamp(m[0] * scale, 0.0F, 1.0F));
    }
    return out;
}

} // namespace alpenglow::prt
