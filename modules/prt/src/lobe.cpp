#include <alpenglow/prt/lobe.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace alpenglow::prt {

void phong_kernel(double exponent, std::span<float> kernel) noexcept {
    std::array<double, 16> integral{};
    integral[0] = 1.0 / (exponent + 1.0);
    integral[1] = 1.0 / (exponent + 2.0);
    for (std::size_t l = 0; l < kernel.size(); ++l) {
        if (l >= 2) {
            const double order = static_cast<double>(l);
            integral[l] = integral[l - 2] * (exponent - order + 2.0) / (exponent + order + 1.0);
        }
        kernel[l] = static_cast<float>(integral[l] / integral[0]);
    }
}

void ggx_kernel(double alpha, std::span<float> kernel) noexcept {
    std::array<double, 16> integral{};
    const double a2 = alpha * alpha;
    constexpr int steps = 4096;
    for (int i = 0; i < steps; ++i) {
        // Steps crowd towards the peak: theta = pi/2 t^2.
        const double t = (i + 0.5) / steps;
        const double theta = pi / 2.0 * t * t;
        const double half = std::cos(theta / 2.0);
        const double d = (a2 - 1.0) * half * half + 1.0;
        const double weight = a2 / (d * d) * std::sin(theta) * t;
        const double z = std::cos(theta);
        double before = 1.0;
        double now = z;
        integral[0] += weight;
        for (std::size_t l = 1; l < kernel.size(); ++l) {
            integral[l] += weight * now;
            const double order = static_cast<double>(l);
            const double next = ((2.0 * order + 1.0) * z * now - order * before) / (order + 1.0);
            before = now;
            now = next;
        }
    }
    for (std::size_t l = 0; l < kernel.size(); ++l) {
        kernel[l] = static_cast<float>(integral[l] / integral[0]);
    }
}

} // namespace alpenglow::prt
