#include <alpenglow/probes/capture.hpp>

#include <alpenglow/sh/image.hpp>

#include <algorithm>
#include <cassert>
#include <limits>
#include <vector>

namespace alpenglow::probes {

glm::vec3 texel_direction(int face, int column, int row, int edge) noexcept {
    assert(face >= 0 && face < 6 && edge > 0);
    return glm::vec3(sh::cube_direction(face, (2.0 * column + 1.0) / edge - 1.0, (2.0 * row + 1.0) / edge - 1.0));
}

void capture_probe(const glm::vec3& point_m, int order, const RenderFace& render, std::span<glm::vec3> out) {
    constexpr int edge = capture_size * capture_supersampling;
    constexpr auto texels = static_cast<std::size_t>(edge * edge);
    std::vector<glm::vec3> pixels(6 * texels);
    sh::CubeMap map;
    map.size = edge;
    for (int face = 0; face < 6; ++face) {
        const std::span<glm::vec3> here = std::span(pixels).subspan(static_cast<std::size_t>(face) * texels, texels);
        render(point_m, face, edge, here);
        map.faces[static_cast<std::size_t>(face)] = {&here.front().x, 3 * texels};
    }
    const Result<std::size_t> broken = sh::project(map, order, out, 2);
    assert(broken); // the sizes fit
    if (!broken || *broken > 0) {
        std::fill(out.begin(), out.end(), glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    }
}

} // namespace alpenglow::probes
