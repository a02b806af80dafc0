// Room for tiles in a square texture: a buddy allocator. A tile of side 2^n lies at a multiple of 2^n, so that its mips
// stay within it down to one texel.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include <alpenglow/core/result.hpp>

namespace alpenglow::impostors {

struct AtlasTile {
    int x = 0; // texels from the upper left
    int y = 0;
    int side = 0; // a power of two
};

class Atlas {
public:
    // `side`: a power of two no larger than the device's greatest texture; least_tile: a power of two, the smallest
    // handed out.
    [[nodiscard]] static Result<Atlas> create(int side, int device_limit, int least_tile = 16);

    // The upper left free tile whose side is the next power of two; empty where none is left, or the atlas is smaller.
    [[nodiscard]] std::optional<AtlasTile> allocate(int side);
    void release(const AtlasTile& tile); // one that allocate gave, once

    [[nodiscard]] int side() const { return side_; }
    [[nodiscard]] int tile_side(int texels) const; // what allocate would hand out for this many texels a side
    [[nodiscard]] std::int64_t free_texels() const { return free_texels_; }
    [[nodiscard]] std::int64_t texels() const { return static_cast<std::int64_t>(side_) * side_; }

private:
    Atlas(int side, int least_tile);
    [[nodiscard]] int level_of(int side) const;

    int side_ = 0;
    int least_ = 0;
    std::int64_t free_texels_ = 0;
    std::vector<std::set<std::uint64_t>> free_; // by level (0: the whole atlas), Morton codes of free tiles
};

} // namespace alpenglow::impostors
