#include <alpenglow/clouds/view.hpp>

#include <alpenglow/core/constants.hpp>

#include <cmath>

namespace alpenglow::clouds {
namespace {

glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

glm::dvec3 unit(const glm::dvec3& v) {
    return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

} // namespace

glm::vec3 Camera::direction(float x, float y) const {
    const float scale = 2.0F * tan_half_height / static_cast<float>(height);
    const float u = (x - 0.5F * static_cast<float>(width)) * scale;
    const float v = (0.5F * static_cast<float>(height) - y) * scale;
    const glm::vec3 d = forward + right * u + up * v;
    return d / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, float tan_half_height, int width, int height) {
    const glm::dvec3 forward = unit(target - eye);
    const glm::dvec3 zenith = std::abs(forward.z) > 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 right = unit(cross(forward, zenith));
    return {eye,   glm::vec3(forward), glm::vec3(right), glm::vec3(cross(right, forward)), tan_half_height, width,
            height};
}

SkySh SkySh::uniform(const glm::vec3& radiance) {
    SkySh sky;
    sky.coefficients[0] = radiance * static_cast<float>(2.0 * std::sqrt(pi));
    sky.bands = 1;
    return sky;
}

glm::vec3 SkySh::radiance(const glm::vec3& direction) const {
    float y[16];
    sh_bands4(direction, y);
    glm::vec3 sum(0.0F);
    for (int i = 0; i < bands * bands; ++i) {
        sum += coefficients[static_cast<std::size_t>(i)] * y[i];
    }
    return sum;
}

void sh_bands4(const glm::vec3& d, float* v) {
    const float x = d.x;
    const float y = d.y;
    const float z = d.z;
    v[0] = 0.28209479F;
    v[1] = -0.48860251F * y;
    v[2] = 0.48860251F * z;
    v[3] = -0.48860251F * x;
    v[4] = 1.09254843F * x * y;
    v[5] = -1.09254843F * y * z;
    v[6] = 0.31539157F * (3.0F * z * z - 1.0F);
    v[7] = -1.09254843F * x * z;
    v[8] = 0.54627422F * (x * x - y * y);
    v[9] = -0.59004359F * y * (3.0F * x * x - y * y);
    v[10] = 2.89061144F * x * y * z;
    v[11] = -0.45704580F * y * (5.0F * z * z - 1.0F);
    v[12] = 0.37317633F * z * (5.0F * z * z - 3.0F);
    v[13] = -0.45704580F * x * (5.0F * z * z - 1.0F);
    v[14] = 1.44530572F * z * (x * x - y * y);
    v[15] = -0.59004359F * x * (x * x - 3.0F * y * y);
}

} // namespace alpenglow::clouds
