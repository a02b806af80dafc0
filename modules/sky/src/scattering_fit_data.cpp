#include <alpenglow/sky/sky_fit.hpp>

#include <cassert>
#include <cstdint>
#include <span>

namespace alpenglow::sky {
namespace {

constexpr std::uint32_t words[] = {
#include "../data/scattering_fit.inc"
};

} // namespace

const SkyFit& scattering_fit() {
    static const SkyFit fit = [] {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(words);
        Result<SkyFit> read = read_fit(std::span(bytes, sizeof(words)), "scattering_fit");
        assert(read && "the shipped table is whole");
        return read ? std::move(*read) : SkyFit{};
    }();
    return fit;
}

} // namespace alpenglow::sky
