#include "sandbox/render/cloud_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/packing.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include "sandbox/render/tone.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float thinnest = 1.0F / 512.0F; // alpha that no display shows

struct View {
    glm::vec3 forward, right, up;
    float tan_x, tan_y; // of the half angles of the picture, beyond the screen's by the rounding of its size
};

View view_of(const CloudRenderData& clouds, const FrameData& frame, std::uint32_t screen_width,
             std::uint32_t screen_height) {
    const glm::mat4& v = frame.view;
    return {-glm::vec3(v[0][2], v[1][2], v[2][2]),
            {v[0][0], v[1][0], v[2][0]},
            {v[0][1], v[1][1], v[2][1]},
            static_cast<float>(clouds.width) * clouds.scale / static_cast<float>(screen_width) /
                std::abs(frame.projection[0][0]),
            static_cast<float>(clouds.height) * clouds.scale / static_cast<float>(screen_height) /
                std::abs(frame.projection[1][1])};
}

glm::vec2 place(const CloudRenderData& clouds, const View& view, float x, float y) {
    return {(2.0F * x / static_cast<float>(clouds.width) - 1.0F) * view.tan_x,
            (1.0F - 2.0F * y / static_cast<float>(clouds.height)) * view.tan_y};
}

// As light.glsl's functions: (1 - e^-x) / x, mean density, transmittance of the air, light that it adds.
float mean_falloff(float x) {
    return std::abs(x) < 1e-3F ? 1.0F - 0.5F * x : (1.0F - std::exp(-x)) / x;
}

glm::vec3 air_transmittance(const gpu::FrameBlock& block, float rise_m, float distance_m) {
    const float from = block.camera_m.z;
    const auto density = [&](float per_m) { return std::exp(-from * per_m) * mean_falloff(rise_m * per_m); };
    const glm::vec3 extinction =
        glm::vec3(block.rayleigh) * density(block.rayleigh.w) + glm::vec3(block.mie) * density(block.mie.w);
    return glm::exp(-extinction * distance_m);
}

glm::vec3 air_color(const gpu::FrameBlock& block, const glm::vec3& direction, float clear) {
    const glm::vec2 along =
        glm::vec2(direction) / std::sqrt(std::max(direction.x * direction.x + direction.y * direction.y, 1e-6F));
    const glm::vec2 light(block.haze.y, block.haze.z);
    const float half_sine = std::sqrt(std::clamp(0.5F - 0.5F * glm::dot(along, light), 0.0F, 1.0F));
    const float at = 16.0F + 16.0F * (along.x * light.y < along.y * light.x ? -half_sine : half_sine);
    const int first = std::min(static_cast<int>(at), 31);
    const float part = at - static_cast<float>(first);
    const glm::vec3 far =
        glm::mix(glm::vec3(block.horizon_light[first]), glm::vec3(block.horizon_light[first + 1]), part);
    const glm::vec3 near = glm::mix(glm::vec3(block.near_light[first]), glm::vec3(block.near_light[first + 1]), part);
    const glm::vec3 lit = glm::mix(far, near, clear);
    const float sunlit = 0.5F * (block.haze.x + 1.0F);
    return glm::mix(glm::min(lit, glm::vec3(block.horizon_light[0])), lit, sunlit);
}

} // namespace

CloudImage make_cloud_image(const CloudRenderData& clouds, const FrameData& frame, const gpu::FrameBlock& block,
                            std::uint32_t screen_width, std::uint32_t screen_height, bool for_display) {
    CloudImage image;
    const View view = view_of(clouds, frame, screen_width, screen_height);
    const auto width = static_cast<std::size_t>(clouds.width);
    const auto height = static_cast<std::size_t>(clouds.height);
    std::vector<glm::vec4> encoded(width * height, glm::vec4(0.0F));
    std::vector<float> depth(width * height, 1e30F); // along the view axis
    parallel_for(height, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            for (std::size_t x = 0; x < width; ++x) {
                const std::size_t pixel = y * width + x;
                const float alpha = 1.0F - clouds.transmittance[pixel];
                if (alpha < thinnest) {
                    continue;
                }
                const glm::vec2 at = place(clouds, view, static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
                const float length = std::sqrt(1.0F + glm::dot(at, at));
                const glm::vec3 direction = (view.forward + at.x * view.right + at.y * view.up) / length;
                const float distance = clouds.distance_m[pixel];
                const glm::vec3 through = air_transmittance(block, direction.z * distance, distance);
                const glm::vec3 radiance = clouds.radiance_cd_m2[pixel] * frame.exposure * through +
                                           air_color(block, direction, through.g) * (1.0F - through) * alpha;
                encoded[pixel] = glm::vec4(
                    for_display ? display(radiance / alpha) * alpha : glm::min(radiance, glm::vec3(6e4F)), alpha);
                depth[pixel] = distance / length;
            }
        }
    });
    // Behind the landscape's outline there is no picture: there, texels take what their neighbours show, so that the
    // screen's finer outline has no seam. What stands in front hides it by its depth.
    std::vector<glm::vec4> filled = encoded;
    for (std::size_t y = 1; y + 1 < height; ++y) {
        for (std::size_t x = 1; x + 1 < width; ++x) {
            const std::size_t pixel = y * width + x;
            const float ground = clouds.landscape_m[pixel];
            if (ground > 1e29F || encoded[pixel].a > 0.0F) {
                continue;
            }
            glm::vec4 sum(0.0F);
            float count = 0.0F;
            for (std::size_t j = y - 1; j <= y + 1; ++j) {
                for (std::size_t i = x - 1; i <= x + 1; ++i) {
                    const std::size_t other = j * width + i;
                    if (clouds.landscape_m[other] > 1.02F * ground) {
                        sum += encoded[other];
                        count += 1.0F;
                    }
                }
            }
            if (count > 0.0F) {
                filled[pixel] = sum / count;
            }
        }
    }
    const std::size_t texel = for_display ? 4 : 8;
    image.texels.resize(width * height * texel);
    for (std::size_t pixel = 0; pixel < filled.size(); ++pixel) {
        if (for_display) {
            const glm::uint32 packed = glm::packUnorm4x8(filled[pixel]);
            std::memcpy(image.texels.data() + 4 * pixel, &packed, 4);
        } else {
            const glm::uint64 packed = glm::packHalf4x16(filled[pixel]);
            std::memcpy(image.texels.data() + 8 * pixel, &packed, 8);
        }
    }
    const glm::mat4 projection = reversed_depth(frame.projection);
    const glm::vec2 beyond(static_cast<float>(clouds.width) * clouds.scale / static_cast<float>(screen_width),
                           static_cast<float>(clouds.height) * clouds.scale / static_cast<float>(screen_height));
    for (std::size_t y = 0; y < height; y += cloud_tile) {
        for (std::size_t x = 0; x < width; x += cloud_tile) {
            const std::size_t x1 = std::min(x + cloud_tile, width);
            const std::size_t y1 = std::min(y + cloud_tile, height);
            float nearest = 1e30F;
            bool any = false;
            for (std::size_t j = y > 0 ? y - 1 : 0; j < std::min(y1 + 1, height); ++j) { // filtered across its border
                for (std::size_t i = x > 0 ? x - 1 : 0; i < std::min(x1 + 1, width); ++i) {
                    any = any || filled[j * width + i].a > thinnest;
                    nearest = std::min(nearest, depth[j * width + i]);
                }
            }
            if (!any || nearest > 1e29F) {
                continue;
            }
            nearest = std::max(0.98F * nearest, 2.0F);
            const float z = projection[3][2] / nearest - projection[2][2];
            const auto corner = [&](std::size_t i, std::size_t j) {
                return CloudVertex{{(2.0F * static_cast<float>(i) / static_cast<float>(width) - 1.0F) * beyond.x,
                                    (2.0F * static_cast<float>(j) / static_cast<float>(height) - 1.0F) * beyond.y},
                                   z};
            };
            const std::array<CloudVertex, 4> c{corner(x, y), corner(x1, y), corner(x, y1), corner(x1, y1)};
            image.vertices.insert(image.vertices.end(), {c[0], c[2], c[1], c[1], c[2], c[3]});
        }
    }
    return image;
}

} // namespace alpenglow::sandbox
