#include <alpenglow/impostors/atlas.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>

namespace alpenglow::impostors {
namespace {

std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
    const auto spread = [](std::uint64_t v) {
        v = (v | (v << 16)) & 0x0000FFFF0000FFFFULL;
        v = (v | (v << 8)) & 0x00FF00FF00FF00FFULL;
        v = (v | (v << 4)) & 0x0F0F0F0F0F0F0F0FULL;
        v = (v | (v << 2)) & 0x3333333333333333ULL;
        return (v | (v << 1)) & 0x5555555555555555ULL;
    };
    return spread(x) | (spread(y) << 1);
}

std::uint32_t every_other_bit(std::uint64_t v) {
    v &= 0x5555555555555555ULL;
    v = (v | (v >> 1)) & 0x3333333333333333ULL;
    v = (v | (v >> 2)) & 0x0F0F0F0F0F0F0F0FULL;
    v = (v | (v >> 4)) & 0x00FF00FF00FF00FFULL;
    v = (v | (v >> 8)) & 0x0000FFFF0000FFFFULL;
    return static_cast<std::uint32_t>(v | (v >> 16));
}

bool power_of_two(int v) {
    return v > 0 && std::has_single_bit(static_cast<unsigned>(v));
}

} // namespace

Result<Atlas> Atlas::create(int side, int device_limit, int least_tile) {
    if (!power_of_two(side)) {
        return Error{"the atlas is " + std::to_string(side) + " texels wide", "impostors: atlas_side",
                     "a power of two"};
    }
    if (side > device_limit) {
        return Error{"the atlas is " + std::to_string(side) + " texels wide", "impostors: atlas_side",
                     "at most " + std::to_string(device_limit) + ", the device's limit"};
    }
    if (!power_of_two(least_tile) || least_tile > side) {
        return Error{"the smallest tile is " + std::to_string(least_tile) + " texels wide", "impostors: least_tile",
                     "a power of two up to " + std::to_string(side)};
    }
    return Atlas(side, least_tile);
}

Atlas::Atlas(int side, int least_tile)
    : side_(side), least_(least_tile), free_texels_(static_cast<std::int64_t>(side) * side),
      free_(static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(side / least_tile))) + 1) {
    free_[0].insert(0);
}

int Atlas::tile_side(int texels) const {
    return std::max(least_, static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(1, texels)))));
}

int Atlas::level_of(int side) const {
    return std::countr_zero(static_cast<unsigned>(side_ / side));
}

std::optional<AtlasTile> Atlas::allocate(int texels) {
    if (texels > side_) {
        return std::nullopt;
    }
    const int side = tile_side(texels);
    const int wanted = level_of(side);
    int level = wanted;
    while (free_[static_cast<std::size_t>(level)].empty()) {
        if (level == 0) {
            return std::nullopt;
        }
        --level;
    }
    std::uint64_t code = *free_[static_cast<std::size_t>(level)].begin();
    free_[static_cast<std::size_t>(level)].erase(code);
    for (; level < wanted; ++level) { // quarter it, and keep the first
        code <<= 2;
        for (std::uint64_t buddy = 1; buddy < 4; ++buddy) {
            free_[static_cast<std::size_t>(level) + 1].insert(code + buddy);
        }
    }
    free_texels_ -= static_cast<std::int64_t>(side) * side;
    return AtlasTile{static_cast<int>(every_other_bit(code)) * side,
                     static_cast<int>(every_other_bit(code >> 1)) * side, side};
}

void Atlas::release(const AtlasTile& tile) {
    assert(tile.side >= least_ && tile.side <= side_);
    free_texels_ += static_cast<std::int64_t>(tile.side) * tile.side;
    int level = level_of(tile.side);
    std::uint64_t code =
        morton(static_cast<std::uint32_t>(tile.x / tile.side), static_cast<std::uint32_t>(tile.y / tile.side));
    for (;;) {
        std::set<std::uint64_t>& peers = free_[static_cast<std::size_t>(level)];
        assert(!peers.contains(code));
        const std::uint64_t first = code & ~std::uint64_t{3};
        bool whole = level > 0;
        for (std::uint64_t buddy = first; buddy < first + 4 && whole; ++buddy) {
            whole = buddy == code || peers.contains(buddy);
        }
        if (!whole) {
            peers.insert(code);
            return;
        }
        for (std::uint64_t buddy = first; buddy < first + 4; ++buddy) {
            peers.erase(buddy);
        }
        code >>= 2;
        --level;
    }
}

} // namespace alpenglow::impostors
