#include "sandbox/app/canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb/stb_easy_font.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace alpenglow::sandbox {
namespace {

std::byte to_byte(float x) {
    return static_cast<std::byte>(std::lround(std::clamp(x, 0.0F, 1.0F) * 255.0F));
}

} // namespace

Canvas::Canvas(int width, int height, glm::vec3 colour, float alpha) : width_(width), height_(height) {
    rgba_.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const std::array<std::byte, 4> pixel{to_byte(colour.r * alpha), to_byte(colour.g * alpha),
                                         to_byte(colour.b * alpha), to_byte(alpha)};
    for (std::size_t i = 0; i < rgba_.size(); i += 4) {
        std::memcpy(&rgba_[i], pixel.data(), 4);
    }
}

glm::vec3 Canvas::at(int x, int y) const {
    const std::size_t i =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
    return glm::vec3(static_cast<float>(rgba_[i]), static_cast<float>(rgba_[i + 1]), static_cast<float>(rgba_[i + 2])) /
           255.0F;
}

void Canvas::set(int x, int y, glm::vec3 colour) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) {
        return;
    }
    const std::size_t i =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
    rgba_[i] = to_byte(colour.r);
    rgba_[i + 1] = to_byte(colour.g);
    rgba_[i + 2] = to_byte(colour.b);
    rgba_[i + 3] = std::byte{255};
}

void Canvas::fill(int left, int top, int right, int bottom, glm::vec3 colour, float strength) {
    for (int y = std::max(top, 0); y < std::min(bottom, height_); ++y) {
        for (int x = std::max(left, 0); x < std::min(right, width_); ++x) {
            set(x, y, strength < 1.0F ? glm::mix(at(x, y), colour, strength) : colour);
        }
    }
}

void Canvas::line(glm::vec2 from, glm::vec2 to, glm::vec3 colour, float width) {
    const float half = 0.5F * width;
    const auto low = [half](float a, float b) { return static_cast<int>(std::floor(std::min(a, b) - half)); };
    const auto high = [half](float a, float b) { return static_cast<int>(std::ceil(std::max(a, b) + half)); };
    const glm::vec2 along = to - from;
    const float length_squared = std::max(glm::dot(along, along), 1e-12F);
    for (int y = std::max(low(from.y, to.y), 0); y <= std::min(high(from.y, to.y), height_ - 1); ++y) {
        for (int x = std::max(low(from.x, to.x), 0); x <= std::min(high(from.x, to.x), width_ - 1); ++x) {
            const glm::vec2 middle(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
            const float part = std::clamp(glm::dot(middle - from, along) / length_squared, 0.0F, 1.0F);
            if (glm::distance(middle, from + part * along) <= half) {
                set(x, y, colour);
            }
        }
    }
}

void Canvas::text(int x, int y, const std::string& text, glm::vec3 colour) {
    struct Corner {
        float x, y, z;
        std::uint32_t colour;
    };
    std::string copy = text;                             // the library takes a char*, and writes nothing to it
    std::vector<Corner> corners(70 * (text.size() + 1)); // its documentation: 270 bytes a letter on average; 1120 here
    const int quads = stb_easy_font_print(static_cast<float>(x), static_cast<float>(y), copy.data(), nullptr,
                                          corners.data(), static_cast<int>(corners.size() * sizeof(Corner)));
    for (std::size_t q = 0; q < static_cast<std::size_t>(quads); ++q) {
        const Corner& low = corners[4 * q];
        const Corner& high = corners[4 * q + 2];
        fill(static_cast<int>(low.x), static_cast<int>(low.y), static_cast<int>(high.x), static_cast<int>(high.y),
             colour);
    }
}

int Canvas::text_width(const std::string& text) {
    std::string copy = text;
    return stb_easy_font_width(copy.data());
}

} // namespace alpenglow::sandbox
