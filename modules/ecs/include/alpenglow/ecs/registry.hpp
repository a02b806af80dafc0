// The registry that the project carries, for games without EnTT: the subset of entt::registry (3.11 or later) that the
// concept in alpenglow/ecs/registry_concept.hpp names, with the same semantics.
#pragma once

#include <alpenglow/ecs/entity.hpp>
#include <alpenglow/ecs/pool.hpp>
#include <alpenglow/ecs/registry_concept.hpp>
#include <alpenglow/ecs/view.hpp>

#include <atomic>
#include <cassert>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace alpenglow {

namespace detail {

// Small numbers for types, in the order of their first use.
inline std::size_t next_type_number() noexcept {
    static std::atomic<std::size_t> next{0};
    return next.fetch_add(1, std::memory_order_relaxed);
}
template <class T>
[[nodiscard]] std::size_t type_number() noexcept {
    static_assert(std::is_same_v<T, std::remove_cvref_t<T>>);
    static const std::size_t number = next_type_number();
    return number;
}

} // namespace detail

// Values of which there is one in a registry, by type. References stay valid while the registry lives.
class RegistryContext {
public:
    // Makes the value from args, or keeps the one that is there.
    template <class T, class... Args>
    T& emplace(Args&&... args) {
        const std::size_t number = detail::type_number<T>();
        if (number >= values_.size()) {
            values_.resize(number + 1);
        }
        if (!values_[number]) {
            values_[number] = std::make_unique<Value<T>>(std::forward<Args>(args)...);
        }
        return static_cast<Value<T>&>(*values_[number]).value;
    }

    // The value must be there.
    template <class T>
    [[nodiscard]] T& get() {
        T* value = find<T>();
        assert(value != nullptr && "no such value in the context");
        return *value;
    }
    template <class T>
    [[nodiscard]] const T& get() const {
        const T* value = find<T>();
        assert(value != nullptr && "no such value in the context");
        return *value;
    }

    // The value, or null.
    template <class T>
    [[nodiscard]] T* find() {
        return const_cast<T*>(std::as_const(*this).template find<std::remove_const_t<T>>());
    }
    template <class T>
    [[nodiscard]] const T* find() const {
        using Plain = std::remove_const_t<T>;
        const std::size_t number = detail::type_number<Plain>();
        return number < values_.size() && values_[number] ? &static_cast<const Value<Plain>&>(*values_[number]).value
                                                          : nullptr;
    }

    template <class T>
    [[nodiscard]] bool contains() const {
        return find<T>() != nullptr;
    }

private:
    struct AnyValue {
        AnyValue() = default;
        AnyValue(const AnyValue&) = delete;
        AnyValue& operator=(const AnyValue&) = delete;
        virtual ~AnyValue() = default;
    };
    template <class T>
    struct Value final : AnyValue {
        template <class... Args>
        explicit Value(Args&&... args) {
            detail::construct_component(&value, std::forward<Args>(args)...);
        }
        Value(const Value&) = delete;
        Value& operator=(const Value&) = delete;
        ~Value() override { std::destroy_at(&value); }
        union {
            T value; // constructed by the rule for components, which an initialiser could not say
        };
    };

    std::vector<std::unique_ptr<AnyValue>> values_; // by type number
};

// Entities and their components. A component type is any movable type that is not empty. Preconditions are asserted.
// Member functions that are const may run at the same time on several threads; nothing else may.
class BasicRegistry {
public:
    using entity_type = Entity;

    explicit BasicRegistry(EntityPool entities = EntityPool{}) : entities_(std::move(entities)) {}

    [[nodiscard]] Entity create() { return entities_.create(); }

    // Destroys a valid entity and all its components.
    void destroy(Entity e) {
        assert(valid(e));
        for (const auto& pool : pools_) {
            if (pool) {
                pool->remove(e);
            }
        }
        entities_.destroy(e);
    }

    [[nodiscard]] bool valid(Entity e) const noexcept { return entities_.valid(e); }

    // Adds a component made from args (with braces, if T is an aggregate) to a valid entity that has none.
    template <class T, class... Args>
    T& emplace(Entity e, Args&&... args) {
        assert(valid(e));
        return assure<T>().emplace(e, std::forward<Args>(args)...);
    }

    template <class T, class... Args>
    T& emplace_or_replace(Entity e, Args&&... args) {
        assert(valid(e));
        detail::Pool<T>& pool = assure<T>();
        if (const std::uint32_t at = pool.position(e); at != detail::SparseSet::absent) {
            return pool.at(at) = T{std::forward<Args>(args)...};
        }
        return pool.emplace(e, std::forward<Args>(args)...);
    }

    // The component of an entity that has one.
    template <class T>
    [[nodiscard]] T& get(Entity e) {
        return const_cast<T&>(std::as_const(*this).template get<T>(e));
    }
    template <class T>
    [[nodiscard]] const T& get(Entity e) const {
        const auto* pool = find<T>();
        assert(pool != nullptr && pool->position(e) != detail::SparseSet::absent && "the entity lacks this component");
        return pool->at(pool->position_of_slot(entity_index(e)));
    }

    // The component, or null.
    template <class T>
    [[nodiscard]] T* try_get(Entity e) {
        return const_cast<T*>(std::as_const(*this).template try_get<T>(e));
    }
    template <class T>
    [[nodiscard]] const T* try_get(Entity e) const {
        const auto* pool = find<T>();
        if (pool == nullptr) {
            return nullptr;
        }
        const std::uint32_t at = pool->position(e);
        return at != detail::SparseSet::absent ? &pool->at(at) : nullptr;
    }

    template <class... T>
    [[nodiscard]] bool all_of(Entity e) const {
        return ((try_get<T>(e) != nullptr) && ...);
    }

    // Removes the component if it is there; returns how many were removed, 0 or 1.
    template <class T>
    std::size_t remove(Entity e) {
        return assure<T>().remove(e) ? 1 : 0;
    }

    // The entities that have all of T; a const T is read only.
    template <class... T>
    [[nodiscard]] View<T...> view() {
        return View<T...>(&assure<std::remove_const_t<T>>()...);
    }
    template <class... T>
    [[nodiscard]] View<const T...> view() const {
        return View<const T...>(find<T>()...);
    }

    [[nodiscard]] RegistryContext& ctx() noexcept { return context_; }
    [[nodiscard]] const RegistryContext& ctx() const noexcept { return context_; }

private:
    template <class T>
    [[nodiscard]] detail::Pool<T>& assure() {
        const std::size_t number = detail::type_number<T>();
        if (number >= pools_.size()) {
            pools_.resize(number + 1);
        }
        if (!pools_[number]) {
            pools_[number] = std::make_unique<detail::Pool<T>>();
        }
        return static_cast<detail::Pool<T>&>(*pools_[number]);
    }

    template <class T>
    [[nodiscard]] const detail::Pool<std::remove_const_t<T>>* find() const noexcept {
        using Plain = std::remove_const_t<T>;
        const std::size_t number = detail::type_number<Plain>();
        return number < pools_.size() ? static_cast<const detail::Pool<Plain>*>(pools_[number].get()) : nullptr;
    }

    EntityPool entities_;
    std::vector<std::unique_ptr<detail::SparseSet>> pools_; // by type number
    RegistryContext context_;
};

static_assert(Registry<BasicRegistry>);

} // namespace alpenglow
