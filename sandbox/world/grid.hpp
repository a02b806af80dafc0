// A square grid of samples of a function on the plane.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>

namespace alpenglow::sandbox {

// `n` x `n` samples, row-major from the south-west corner: sample (i, j) stands at origin_m + spacing_m * (i, j).
struct HeightGrid {
    int n = 0;
    float spacing_m = 0.0F;
    glm::vec2 origin_m{0.0F};
    std::vector<float> height_m;

    [[nodiscard]] std::size_t index(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(n) + static_cast<std::size_t>(i);
    }
    [[nodiscard]] float at(int i, int j) const { return height_m[index(i, j)]; }
    [[nodiscard]] float at_clamped(int i, int j) const { return at(std::clamp(i, 0, n - 1), std::clamp(j, 0, n - 1)); }
    [[nodiscard]] glm::vec2 position_m(int i, int j) const {
        return origin_m + spacing_m * glm::vec2(static_cast<float>(i), static_cast<float>(j));
    }
    [[nodiscard]] float extent_m() const { return spacing_m * static_cast<float>(n - 1); }
};

// An n x n grid of side `extent_m` centred on (0, 0), heights 0.
[[nodiscard]] HeightGrid make_grid(int n, float spacing_m);

// Bilinear height, clamped at the border.
[[nodiscard]] float sample_bilinear(const HeightGrid& grid, glm::vec2 position_m);

// Catmull-Rom (C1) height, clamped at the border.
[[nodiscard]] float sample_cubic(const HeightGrid& grid, glm::vec2 position_m);

} // namespace alpenglow::sandbox
