// Storage of one component type: a sparse set from entities to positions, and the components in pages that never move.
#pragma once

#include <alpenglow/ecs/entity.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace alpenglow::detail {

// EnTT's rule for T(args...): aggregates take braces.
template <class T, class... Args>
T* construct_component(T* where, Args&&... args) {
    if constexpr (std::is_aggregate_v<T> && sizeof...(Args) != 0) {
        return std::construct_at(where, T{std::forward<Args>(args)...});
    } else {
        return std::construct_at(where, std::forward<Args>(args)...);
    }
}

// The entities that a pool holds, densely packed, without the components' type.
class SparseSet {
public:
    static constexpr std::uint32_t absent = 0xFFFFFFFFU;

    SparseSet(const SparseSet&) = delete;
    SparseSet& operator=(const SparseSet&) = delete;
    virtual ~SparseSet() = default;

    [[nodiscard]] std::size_t size() const noexcept { return packed_.size(); }
    [[nodiscard]] Entity entity(std::size_t position) const noexcept { return packed_[position]; }

    // Where the living entity in slot `index` is, or absent.
    [[nodiscard]] std::uint32_t position_of_slot(std::uint32_t index) const noexcept {
        const std::size_t page = index / slots_per_page;
        return page < pages_.size() && pages_[page] ? (*pages_[page])[index % slots_per_page] : absent;
    }

    // Where an entity is, or absent; a stale handle is absent.
    [[nodiscard]] std::uint32_t position(Entity e) const noexcept {
        const std::uint32_t at = position_of_slot(entity_index(e));
        return at != absent && packed_[at] == e ? at : absent;
    }

    // Whether `other` holds the same entities at the positions first .. last - 1.
    [[nodiscard]] bool in_step(const SparseSet& other, std::size_t first, std::size_t last) const noexcept {
        return other.size() >= last &&
               std::memcmp(packed_.data() + first, other.packed_.data() + first, (last - first) * sizeof(Entity)) == 0;
    }

    // Removes the entity if it is there: the last one takes its place.
    bool remove(Entity e) {
        const std::uint32_t at = position(e);
        if (at == absent) {
            return false;
        }
        swap_and_pop(at);
        const Entity last = packed_.back();
        packed_[at] = last;
        slot(entity_index(last)) = at;
        slot(entity_index(e)) = absent; // in this order, since e may be the last
        packed_.pop_back();
        return true;
    }

protected:
    SparseSet() = default;

    // Appends an entity that is not there.
    void append(Entity e) {
        const std::size_t page = entity_index(e) / slots_per_page;
        if (page >= pages_.size()) {
            pages_.resize(page + 1);
        }
        if (!pages_[page]) {
            pages_[page] = std::make_unique<Page>();
            pages_[page]->fill(absent);
        }
        packed_.push_back(e);
        slot(entity_index(e)) = static_cast<std::uint32_t>(packed_.size() - 1);
    }

private:
    static constexpr std::size_t slots_per_page = 4096;
    using Page = std::array<std::uint32_t, slots_per_page>;

    // Moves the last component over the one at `position` and destroys what is left of it.
    virtual void swap_and_pop(std::size_t position) = 0;

    [[nodiscard]] std::uint32_t& slot(std::uint32_t index) noexcept {
        return (*pages_[index / slots_per_page])[index % slots_per_page];
    }

    std::vector<Entity> packed_;
    std::vector<std::unique_ptr<Page>> pages_; // position by slot; null where no slot of the page is in use
};

// The components of one type, at the positions that the sparse set says.
template <class T>
class Pool final : public SparseSet {
    static_assert(!std::is_empty_v<T>, "components carry data: EnTT leaves empty types out of each()");
    static_assert(std::is_move_constructible_v<T> && std::is_move_assignable_v<T>, "removal moves components");

public:
    // Components a page: a power of two, about 1 MiB. Untouched memory of a page costs address space alone, and a
    // million entities with three components are iterated about a sixth faster than with pages of 16 KiB.
    static constexpr std::size_t page_bytes = std::size_t{1} << 20U;
    static constexpr std::size_t page_size = std::bit_floor(sizeof(T) < page_bytes ? page_bytes / sizeof(T) : 1);

    Pool() = default;
    ~Pool() override {
        for (std::size_t i = 0; i < size(); ++i) {
            std::destroy_at(&at(i));
        }
        for (T* page : pages_) {
            std::allocator<T>{}.deallocate(page, page_size);
        }
    }

    [[nodiscard]] T& at(std::size_t position) noexcept { return pages_[position / page_size][position % page_size]; }
    [[nodiscard]] const T& at(std::size_t position) const noexcept {
        return pages_[position / page_size][position % page_size];
    }

    template <class... Args>
    T& emplace(Entity e, Args&&... args) {
        assert(position(e) == absent && "the entity has this component already");
        if (size() == pages_.size() * page_size) {
            pages_.push_back(std::allocator<T>{}.allocate(page_size));
        }
        T* component = construct_component(&at(size()), std::forward<Args>(args)...);
        append(e);
        return *component;
    }

private:
    void swap_and_pop(std::size_t position) override {
        T& last = at(size() - 1);
        if (position != size() - 1) {
            at(position) = std::move(last);
        }
        std::destroy_at(&last);
    }

    std::vector<T*> pages_;
};

} // namespace alpenglow::detail
