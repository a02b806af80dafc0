// Views: iteration over the entities that have all of some components.
#pragma once

#include <alpenglow/ecs/pool.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <type_traits>
#include <utility>

namespace alpenglow {

// The entities that have every T, led by the pool that is smallest when each() is called. Both forms of each() run from
// the last position of that pool to the first. Therefore
//  - entities and components added meanwhile go behind and are not visited;
//  - destroying the current entity, or removing its components, is legal: what takes its place has been visited.
// Removing the components of another entity that the view iterates is not.
template <class... T>
class View {
    template <class C>
    using PoolOf = std::conditional_t<std::is_const_v<C>, const detail::Pool<std::remove_const_t<C>>, detail::Pool<C>>;
    using Pools = std::tuple<PoolOf<T>*...>;
    using Positions = std::array<std::uint32_t, sizeof...(T)>;
    using Indices = std::index_sequence_for<T...>;
    static constexpr std::uint32_t absent = detail::SparseSet::absent;

public:
    // Null stands for a pool that nothing was ever added to.
    explicit View(PoolOf<T>*... pools) noexcept : pools_(pools...) {}

    // Input iterator over (Entity, T&...).
    class Iterator {
    public:
        using iterator_category = std::input_iterator_tag;
        using difference_type = std::ptrdiff_t;
        using value_type = std::tuple<Entity, T&...>;
        using reference = value_type;
        using pointer = void;

        Iterator() = default;
        Iterator(const Pools& pools, const detail::SparseSet* leader) noexcept
            : pools_(pools), leader_(leader), left_(leader != nullptr ? leader->size() : 0) {
            find_match();
        }

        [[nodiscard]] value_type operator*() const noexcept { return dereference(Indices{}); }
        Iterator& operator++() noexcept {
            --left_;
            find_match();
            return *this;
        }
        void operator++(int) noexcept { ++*this; }
        [[nodiscard]] bool operator==(std::default_sentinel_t /*end*/) const noexcept { return left_ == 0; }

    private:
        void find_match() noexcept {
            while (left_ != 0 && !match(Indices{})) {
                --left_;
            }
        }
        template <std::size_t... I>
        [[nodiscard]] bool match(std::index_sequence<I...> /*all*/) noexcept {
            const std::uint32_t slot = entity_index(leader_->entity(left_ - 1));
            return (
                ((at_[I] = std::get<I>(pools_) == leader_ ? static_cast<std::uint32_t>(left_ - 1)
                                                          : std::get<I>(pools_)->position_of_slot(slot)) != absent) &&
                ...);
        }
        template <std::size_t... I>
        [[nodiscard]] value_type dereference(std::index_sequence<I...> /*all*/) const noexcept {
            return {leader_->entity(left_ - 1), std::get<I>(pools_)->at(at_[I])...};
        }

        Pools pools_{};
        const detail::SparseSet* leader_ = nullptr;
        std::size_t left_ = 0; // one past the current position
        Positions at_{};       // the current entity's position in each pool
    };

    class Range {
    public:
        explicit Range(Iterator begin) noexcept : begin_(begin) {}
        [[nodiscard]] Iterator begin() const noexcept { return begin_; }
        [[nodiscard]] std::default_sentinel_t end() const noexcept { return {}; }

    private:
        Iterator begin_;
    };

    // for (auto [entity, a, b] : view.each())
    [[nodiscard]] Range each() const noexcept { return Range(Iterator(pools_, leader(Indices{}))); }

    // Calls visit(Entity, T&...) for each: the faster form.
    template <class Visit>
    void each(Visit visit) const {
        each_led(visit, leader(Indices{}), Indices{});
    }

private:
    template <std::size_t... I>
    [[nodiscard]] const detail::SparseSet* leader(std::index_sequence<I...> /*all*/) const noexcept {
        if (((std::get<I>(pools_) == nullptr) || ...)) {
            return nullptr;
        }
        const detail::SparseSet* smallest = std::get<0>(pools_);
        ((smallest = std::get<I>(pools_)->size() < smallest->size() ? std::get<I>(pools_) : smallest), ...);
        return smallest;
    }

    template <class Visit, std::size_t... I>
    void each_led(Visit& visit, const detail::SparseSet* leader, std::index_sequence<I...> all) const {
        static_cast<void>(
            ((std::get<I>(pools_) == leader && leader != nullptr ? (each_led_by<I>(visit, all), true) : false) || ...));
    }

    // Works in blocks that lie within one page of every pool. Where all pools hold a block's entities at the same
    // positions, as they do when entities get their components together, the block needs no lookup. That stays true
    // while the visits change what they may: only positions from the current one on are touched.
    template <std::size_t Lead, class Visit, std::size_t... I>
    void each_led_by(Visit& visit, std::index_sequence<I...> /*all*/) const {
        constexpr std::size_t block =
            std::min({std::size_t{1024}, std::remove_pointer_t<std::tuple_element_t<I, Pools>>::page_size...});
        const Pools pools = pools_;
        const auto& lead = *std::get<Lead>(pools);
        for (std::size_t left = lead.size(); left != 0;) {
            const std::size_t first = (left - 1) / block * block;
            if (((I == Lead || lead.in_step(*std::get<I>(pools), first, left)) && ...)) {
                const std::tuple<T*...> components(&std::get<I>(pools)->at(first)...);
                for (std::size_t i = left - first; i-- != 0;) {
                    visit(lead.entity(first + i), std::get<I>(components)[i]...);
                }
                left = first;
                continue;
            }
            for (; left != first; --left) {
                const Entity entity = lead.entity(left - 1);
                const std::uint32_t slot = entity_index(entity);
                Positions at;
                if ((((at[I] = I == Lead ? static_cast<std::uint32_t>(left - 1)
                                         : std::get<I>(pools)->position_of_slot(slot)) != absent) &&
                     ...)) {
                    visit(entity, std::get<I>(pools)->at(at[I])...);
                }
            }
        }
    }

    Pools pools_;
};

} // namespace alpenglow
