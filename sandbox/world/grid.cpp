#include "grid.hpp"

#include <cmath>

namespace alpenglow::sandbox {

HeightGrid make_grid(int n, float spacing_m) {
    HeightGrid grid;
    grid.n = n;
    grid.spacing_m = spacing_m;
    grid.origin_m = glm::vec2(-0.5F * spacing_m * static_cast<float>(n - 1));
    grid.height_m.assign(static_cast<std::size_t>(n) * static_cast<std::size_t>(n), 0.0F);
    return grid;
}

float sample_bilinear(const HeightGrid& grid, glm::vec2 position_m) {
    const float limit = static_cast<float>(grid.n - 1);
    const float x = std::clamp((position_m.x - grid.origin_m.x) / grid.spacing_m, 0.0F, limit);
    const float y = std::clamp((position_m.y - grid.origin_m.y) / grid.spacing_m, 0.0F, limit);
    const int i = std::min(static_cast<int>(x), grid.n - 2);
    const int j = std::min(static_cast<int>(y), grid.n - 2);
    const float u = x - static_cast<float>(i);
    const float v = y - static_cast<float>(j);
    const float low = grid.at(i, j) + u * (grid.at(i + 1, j) - grid.at(i, j));
    const float high = grid.at(i, j + 1) + u * (grid.at(i + 1, j + 1) - grid.at(i, j + 1));
    return low + v * (high - low);
}

namespace {

float cubic(float a, float b, float c, float d, float t) {
    return b + 0.5F * t * (c - a + t * (2.0F * a - 5.0F * b + 4.0F * c - d + t * (3.0F * (b - c) + d - a)));
}

} // namespace

float sample_cubic(const HeightGrid& grid, glm::vec2 position_m) {
    const float limit = static_cast<float>(grid.n - 1);
    const float x = std::clamp((position_m.x - grid.origin_m.x) / grid.spacing_m, 0.0F, limit);
    const float y = std::clamp((position_m.y - grid.origin_m.y) / grid.spacing_m, 0.0F, limit);
    const int i = std::min(static_cast<int>(x), grid.n - 2);
    const int j = std::min(static_cast<int>(y), grid.n - 2);
    const float u = x - static_cast<float>(i);
    float rows[4];
    for (int r = 0; r < 4; ++r) {
        const int row = j - 1 + r;
        rows[r] = cubic(grid.at_clamped(i - 1, row), grid.at_clamped(i, row), grid.at_clamped(i + 1, row),
                        grid.at_clamped(i + 2, row), u);
    }
    return cubic(rows[0], rows[1], rows[2], rows[3], y - static_cast<float>(j));
}

} // namespace alpenglow::sandbox
