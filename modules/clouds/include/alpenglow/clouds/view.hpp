// What reference and real-time images share: camera, lights, sky, pictures.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::clouds {

// Pinhole camera. forward, right, up: orthonormal, world frame.
struct Camera {
    glm::dvec3 position_m{0.0};
    glm::vec3 forward{0.0F, 1.0F, 0.0F};
    glm::vec3 right{1.0F, 0.0F, 0.0F};
    glm::vec3 up{0.0F, 0.0F, 1.0F};
    float tan_half_height = 0.4F; // tangent of half the vertical field of view
    int width = 96;               // pixels
    int height = 54;

    // Unit direction through the point (x, y) of the picture, in pixels from its upper left corner.
    [[nodiscard]] glm::vec3 direction(float x, float y) const;
};

// A camera at `eye` that looks at `target` with the zenith up.
[[nodiscard]] Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, float tan_half_height, int width,
                             int height);

// Sun, moon or any light from a direction. irradiance: on a surface facing it; RGB in the scene's unit (lux).
struct DirectionalLight {
    glm::vec3 to_light{0.0F, 0.0F, 1.0F}; // unit, world frame
    glm::vec3 irradiance{1.0F};
    float angular_radius_rad =
        0.0F; // 0: a point at infinity. The reference samples the disc, real time takes its centre
};

// Radiance from outside the cloud, for every direction (ground below the horizon included): real orthonormal SH with
// index l(l+1)+m and signs Y_1^-1 = -0.4886 y, Y_1^0 = 0.4886 z, Y_1^1 = -0.4886 x, up to band 3, in the world frame;
// RGB in the scene's unit (cd/m^2).
struct SkySh {
    std::array<glm::vec3, 16> coefficients{};
    int bands = 0; // 0: no sky; 1: uniform; up to 4

    static SkySh uniform(const glm::vec3& radiance);
    [[nodiscard]] glm::vec3 radiance(const glm::vec3& direction) const;
};

// Linear RGB radiance of light from the cloud (premultiplied), transmittance, and mean depth.
struct Picture {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> radiance;  // scattered towards the eye by the cloud, without what lies behind
    std::vector<float> transmittance; // of what lies behind, 0 .. 1
    std::vector<float> depth_m;       // mean distance of what is seen of the cloud; 0 where there is none
    std::vector<float> spread_m;      // its standard deviation along the ray

    Picture() = default;
    Picture(int w, int h)
        : width(w), height(h), radiance(std::size_t(w) * std::size_t(h), glm::vec3(0.0F)),
          transmittance(radiance.size(), 1.0F), depth_m(radiance.size(), 0.0F), spread_m(radiance.size(), 0.0F) {}
};

// The 16 real SH functions up to band 3 at a unit direction, in SkySh's order and signs.
void sh_bands4(const glm::vec3& direction, float* values16);

} // namespace alpenglow::clouds
