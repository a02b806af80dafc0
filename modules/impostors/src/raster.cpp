#include <alpenglow/impostors/raster.hpp>

#include <cassert>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace alpenglow::impostors {

glm::mat4 clip_from_eye(const Frustum& view, double near_m, double far_m) {
    assert(near_m > 0.0 && far_m > near_m);
    const double width = view.tan_right - view.tan_left;
    const double height = view.tan_top - view.tan_bottom;
    // Rows of the matrix, as what they make of a position.
    const glm::dvec3 x = (2.0 * view.right - (view.tan_right + view.tan_left) * view.forward) / width;
    const glm::dvec3 y = ((view.tan_top + view.tan_bottom) * view.forward - 2.0 * view.up) / height;
    const double slope = near_m / (far_m - near_m);
    const glm::dvec3 z = -slope * view.forward;
    return glm::transpose(glm::mat4(glm::vec4(glm::vec3(x), 0.0F), glm::vec4(glm::vec3(y), 0.0F),
                                    glm::vec4(glm::vec3(z), static_cast<float>(slope * far_m)),
                                    glm::vec4(glm::vec3(view.forward), 0.0F)));
}

double axis_depth(double near_m, double far_m, float depth) {
    return near_m * far_m / (near_m + static_cast<double>(depth) * (far_m - near_m));
}

void fill_slab(const CaptureRequest& request, double near_m, double far_m, std::span<const glm::vec4> colour,
               std::span<const float> depth, int samples, SlabImage& image) {
    const int width = request.view.width;
    const int height = request.view.height;
    const auto line = static_cast<std::size_t>(width) * static_cast<std::size_t>(samples);
    assert(colour.size() == line * static_cast<std::size_t>(height) * static_cast<std::size_t>(samples));
    assert(depth.size() == colour.size());
    const float share = 1.0F / static_cast<float>(samples * samples);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            glm::vec4 sum(0.0F);
            glm::vec2 moments(0.0F);
            for (int k = 0; k < samples * samples; ++k) {
                const std::size_t at = static_cast<std::size_t>(y * samples + k / samples) * line +
                                       static_cast<std::size_t>(x * samples + k % samples);
                const glm::vec4& c = colour[at];
                sum += share * c;
                if (c.w > 0.0F) {
                    const auto s = static_cast<float>((axis_depth(near_m, far_m, depth[at]) - request.depth_origin_m) /
                                                      request.depth_scale_m);
                    moments += share * c.w * glm::vec2(s, s * s);
                }
            }
            const auto i = static_cast<std::size_t>(y * width + x);
            image.colour[i] = sum;
            image.depth[i] = moments;
        }
    }
}

} // namespace alpenglow::impostors
