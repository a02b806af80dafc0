#include "sandbox/app/picture_difference.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::sandbox {

PictureDifference picture_difference(std::span<const std::byte> a, std::span<const std::byte> b) {
    assert(a.size() == b.size() && a.size() % 4 == 0);
    PictureDifference result;
    result.amplified.resize(a.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (i % 4 == 3) {
            result.amplified[i] = std::byte{255};
            continue;
        }
        const int difference = std::to_integer<int>(a[i]) - std::to_integer<int>(b[i]);
        sum += static_cast<double>(difference) * difference;
        result.amplified[i] = static_cast<std::byte>(std::min(255, 16 * std::abs(difference)));
    }
    const double mean = sum / (0.75 * static_cast<double>(std::max<std::size_t>(a.size(), 4)));
    result.psnr_db = mean > 0.0 ? std::min(99.0, 10.0 * std::log10(255.0 * 255.0 / mean)) : 99.0;
    return result;
}

double temporal_difference(std::span<const std::byte> before, std::span<const std::byte> now,
                           std::span<const std::byte> reference_before, std::span<const std::byte> reference_now) {
    assert(before.size() == now.size() && now.size() == reference_before.size() && now.size() == reference_now.size() &&
           now.size() % 4 == 0);
    double sum = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        if (i % 4 == 3) {
            continue;
        }
        const int change = (std::to_integer<int>(now[i]) - std::to_integer<int>(before[i])) -
                           (std::to_integer<int>(reference_now[i]) - std::to_integer<int>(reference_before[i]));
        sum += static_cast<double>(change) * change;
    }
    return std::sqrt(sum / (0.75 * static_cast<double>(std::max<std::size_t>(now.size(), 4))));
}

} // namespace alpenglow::sandbox
