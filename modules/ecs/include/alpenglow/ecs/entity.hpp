// Entities: 64-bit handles that carry a version, and the pool that hands them out.
#pragma once

#include <cassert>
#include <cstdint>
#include <limits>
#include <vector>

namespace alpenglow {

// A handle: the index of a slot in the low 32 bits, the slot's version in the high 32. A value-initialised Entity{} is
// never valid.
enum class Entity : std::uint64_t {};

[[nodiscard]] constexpr std::uint32_t entity_index(Entity e) noexcept {
    return static_cast<std::uint32_t>(e);
}
[[nodiscard]] constexpr std::uint32_t entity_version(Entity e) noexcept {
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(e) >> 32U);
}
[[nodiscard]] constexpr Entity make_entity(std::uint32_t index, std::uint32_t version) noexcept {
    return static_cast<Entity>((static_cast<std::uint64_t>(version) << 32U) | index);
}

// Hands out handles and recycles slots, the one freed last first. A slot's version goes up by one at each creation and
// at each destruction, so that it is odd exactly while the entity lives. Where it would pass `last_version` the slot is
// retired instead of reused: no handle is ever given out twice, and a stale one is never valid again.
class EntityPool {
public:
    // last_version: odd; tests shorten a slot's life with it, which is 2^31 entities otherwise.
    explicit EntityPool(std::uint32_t last_version = std::numeric_limits<std::uint32_t>::max())
        : last_version_(last_version) {
        assert(last_version % 2 == 1);
    }

    [[nodiscard]] Entity create() {
        if (free_.empty()) {
            assert(versions_.size() < std::numeric_limits<std::uint32_t>::max() &&
                   "the index of an entity has 32 bits");
            versions_.push_back(1);
            return make_entity(static_cast<std::uint32_t>(versions_.size() - 1), 1);
        }
        const std::uint32_t index = free_.back();
        free_.pop_back();
        return make_entity(index, ++versions_[index]);
    }

    void destroy(Entity e) {
        assert(valid(e));
        std::uint32_t& version = versions_[entity_index(e)];
        if (version == last_version_) {
            version = 0; // retired: 0 is even, and no handle to this slot is made any more
            return;
        }
        ++version;
        free_.push_back(entity_index(e));
    }

    [[nodiscard]] bool valid(Entity e) const noexcept {
        const std::uint32_t index = entity_index(e);
        const std::uint32_t version = entity_version(e);
        return version % 2 == 1 && index < versions_.size() && versions_[index] == version;
    }

private:
    std::vector<std::uint32_t> versions_; // of each slot; odd while it is in use
    std::vector<std::uint32_t> free_;     // slots to reuse
    std::uint32_t last_version_;
};

} // namespace alpenglow
