#include "sandbox/app/probe_display.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include <alpenglow/sh/dering.hpp>
#include <alpenglow/sh/irradiance.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr std::uint32_t rings = 20; // from pole to pole
constexpr std::uint32_t meridians = 24;
constexpr float shown_albedo = 0.3F;
constexpr glm::vec3 negative_color(0.9F, 0.02F, 0.02F);
constexpr glm::vec3 positive_pin(0.05F, 0.3F, 1.0F);

float luminance(const glm::vec3& rgb) {
    return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b;
}

// Symbols are shaded a little, from above, so that their shape can be read.
glm::vec4 symbol(const glm::vec3& color, const glm::vec3& outwards) {
    return {color * (0.7F + 0.3F * outwards.z), 1.0F};
}

void append_pin(const glm::vec3& at_m, const glm::vec3& color, std::vector<ColorVertex>& vertices,
                std::vector<std::uint32_t>& indices) {
    constexpr float size_m = 0.03F;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (int k = 0; k < 6; ++k) { // +x -x +y -y +z -z
        glm::vec3 out(0.0F);
        out[k / 2] = k % 2 == 0 ? 1.0F : -1.0F;
        vertices.push_back({at_m + size_m * out, symbol(color, out)});
    }
    for (const std::uint32_t k : {0U, 2U, 4U, 2U, 1U, 4U, 1U, 3U, 4U, 3U, 0U, 4U,    // above
                                  2U, 0U, 5U, 1U, 2U, 5U, 3U, 1U, 5U, 0U, 3U, 5U}) { // below
        indices.push_back(first + k);
    }
}

} // namespace

void append_probe_display(std::span<const glm::vec3> radiance, const glm::vec3& centre_m, float mean_radius_m,
                          std::vector<ColorVertex>& vertices, std::vector<std::uint32_t>& indices) {
    std::array<glm::vec3, 9> lux{};
    sh::irradiance(3, radiance.first(9), std::span<glm::vec3>(lux));
    std::array<double, 9> luminous{};
    for (std::size_t i = 0; i < lux.size(); ++i) {
        luminous[i] = luminance(lux[i]);
    }
    const float mean = static_cast<float>(luminous[0]) * 0.28209479F;
    if (!(mean > 0.0F)) {
        return;
    }
    const auto radius = [&](float value) { return mean_radius_m * (0.5F + 0.5F * std::sqrt(std::abs(value) / mean)); };

    // The mesh's pole looks towards the light, so that its rings follow the lobes around it.
    glm::vec3 pole(-static_cast<float>(luminous[3]), -static_cast<float>(luminous[1]), static_cast<float>(luminous[2]));
    pole = glm::dot(pole, pole) > 0.0F ? glm::normalize(pole) : glm::vec3(0.0F, 0.0F, 1.0F);
    const glm::vec3 aside = std::abs(pole.z) < 0.9F ? glm::vec3(0.0F, 0.0F, 1.0F) : glm::vec3(1.0F, 0.0F, 0.0F);
    const glm::vec3 right = glm::normalize(glm::cross(aside, pole));
    const glm::vec3 up = glm::cross(pole, right);
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t r = 0; r <= rings; ++r) {
        const float polar = pi_f * static_cast<float>(r) / static_cast<float>(rings);
        for (std::uint32_t m = 0; m <= meridians; ++m) {
            const float azimuth = 2.0F * pi_f * static_cast<float>(m) / static_cast<float>(meridians);
            const glm::vec3 out =
                std::cos(polar) * pole + std::sin(polar) * (std::cos(azimuth) * right + std::sin(azimuth) * up);
            const glm::vec3 value = sh::evaluate(3, std::span<const glm::vec3>(lux), out);
            const float amount = luminance(value);
            const glm::vec4 light = amount < 0.0F
                                        ? symbol(negative_color, out)
                                        : glm::vec4(shown_albedo / pi_f * glm::max(value, glm::vec3(0.0F)), 0.0F);
            vertices.push_back({centre_m + radius(amount) * out, light});
        }
    }
    for (std::uint32_t r = 0; r < rings; ++r) {
        for (std::uint32_t m = 0; m < meridians; ++m) {
            const std::uint32_t v = first + r * (meridians + 1) + m;
            const std::uint32_t below = v + meridians + 1;
            indices.insert(indices.end(), {v, below, v + 1, v + 1, below, below + 1});
        }
    }
    const sh::Minimum least = sh::quadratic_minimum(luminous);
    const auto least_value = static_cast<float>(least.value);
    append_pin(centre_m + (radius(least_value) + 0.05F) * glm::vec3(least.direction),
               least.value < -sh::dering_tolerance * luminous[0] ? negative_color : positive_pin, vertices, indices);
}

} // namespace alpenglow::sandbox
