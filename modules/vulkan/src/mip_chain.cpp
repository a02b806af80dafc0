#include <alpenglow/vulkan/mip_chain.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <iterator>

namespace alpenglow::vulkan {
namespace {

constexpr std::size_t kChannels = 4;

// Averages `count` lines of `from` texels down to `to`; texel i of line k stands at k * line + i * step. The result is
// laid out likewise with its own strides.
struct Strides {
    std::size_t line, step;
};
void average(const std::vector<float>& in, std::size_t from, Strides in_at, std::vector<float>& out, std::size_t to,
             Strides out_at, std::size_t count) {
    const double scale = static_cast<double>(from) / static_cast<double>(to);
    for (std::size_t i = 0; i < to; ++i) {
        const double begin = static_cast<double>(i) * scale;
        const double end = begin + scale;
        const auto first = static_cast<std::size_t>(begin);
        const std::size_t last = std::min(static_cast<std::size_t>(std::ceil(end - 1e-9)), from);
        for (std::size_t k = 0; k < count; ++k) {
            for (std::size_t channel = 0; channel < kChannels; ++channel) {
                double sum = 0.0;
                for (std::size_t j = first; j < last; ++j) {
                    const double covered =
                        std::min(end, static_cast<double>(j + 1)) - std::max(begin, static_cast<double>(j));
                    sum += covered * static_cast<double>(in[(k * in_at.line + j * in_at.step) * kChannels + channel]);
                }
                out[(k * out_at.line + i * out_at.step) * kChannels + channel] = static_cast<float>(sum / scale);
            }
        }
    }
}

} // namespace

std::uint32_t mip_level_count(VkExtent2D extent) {
    return static_cast<std::uint32_t>(std::bit_width(std::max(extent.width, extent.height)));
}

VkExtent2D mip_extent(VkExtent2D extent, std::uint32_t level) {
    return {std::max(extent.width >> level, 1U), std::max(extent.height >> level, 1U)};
}

std::vector<std::byte> make_mip_chain(std::span<const std::byte> texels, VkExtent2D extent) {
    assert(texels.size() == std::size_t{extent.width} * extent.height * kChannels);
    std::vector<std::byte> chain(texels.begin(), texels.end());
    std::vector<float> level(texels.size());
    std::transform(texels.begin(), texels.end(), level.begin(),
                   [](std::byte b) { return static_cast<float>(std::to_integer<int>(b)); });
    for (std::uint32_t i = 1; i < mip_level_count(extent); ++i) {
        const VkExtent2D from = mip_extent(extent, i - 1);
        const VkExtent2D to = mip_extent(extent, i);
        std::vector<float> narrow(std::size_t{to.width} * from.height * kChannels);
        average(level, from.width, {from.width, 1}, narrow, to.width, {to.width, 1}, from.height);
        level.resize(std::size_t{to.width} * to.height * kChannels);
        average(narrow, from.height, {1, to.width}, level, to.height, {1, to.width}, to.width);
        std::transform(level.begin(), level.end(), std::back_inserter(chain),
                       [](float value) { return static_cast<std::byte>(std::lround(value)); });
    }
    return chain;
}

} // namespace alpenglow::vulkan
