#include "sandbox/app/exposure.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>

#include <alpenglow/core/quiet.hpp>

namespace alpenglow::sandbox {

float automatic_exposure(float luminance_cd_m2, float bias_ev) {
    constexpr float darkest_cd_m2 = 1e-4F; // a moonless, overcast night
    constexpr float brightest_cd_m2 = 1e6F;
    float luminance = brightest_cd_m2;
    if (is_number(luminance_cd_m2)) {
        luminance = std::clamp(luminance_cd_m2, darkest_cd_m2, brightest_cd_m2);
    }
    const float key = std::max(0.05F, 1.03F - 2.0F / (2.0F + std::log10(luminance + 1.0F)));
    const float bias = within(bias_ev, -20.0F, 20.0F) ? bias_ev : 0.0F;
    return key / luminance * std::exp2(bias);
}

float adapt_exposure(float current, float target, float dt_s) {
    if (!within(current, FLT_MIN, FLT_MAX) || !within(dt_s, 0.0F, FLT_MAX)) {
        return target;
    }
    const float time_constant_s = target < current ? 0.4F : 1.5F;
    const float step = -std::expm1(-dt_s / time_constant_s);
    return current * std::pow(target / current, step);
}

} // namespace alpenglow::sandbox
