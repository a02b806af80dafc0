// What a system asks of a registry. Both the registry carried here (alpenglow/ecs/registry.hpp) and entt::registry
// (3.11 or later) meet it; a game on EnTT includes this header alone and passes its own.
#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>

namespace alpenglow {

namespace detail {

// Stand-ins for any two components and any value of the context.
struct ProbeA {
    int value = 0;
};
struct ProbeB {
    float value = 0.0F;
};

// A view: a range of tuples, and each(fn) with the entity first.
template <class V, class E, class... T>
concept ViewOf = requires(const V& view, void (&visit)(E, T&...)) {
    view.each(visit);
    view.each().begin() != view.each().end();
    { *view.each().begin() } -> std::convertible_to<std::tuple<E, T&...>>;
};

// The context of a registry: one value a type.
template <class C>
concept Context = requires(C& context, const C& constant) {
    { context.template emplace<ProbeA>(1) } -> std::same_as<ProbeA&>;
    { context.template get<ProbeA>() } -> std::same_as<ProbeA&>;
    { context.template find<ProbeA>() } -> std::same_as<ProbeA*>;
    { constant.template get<ProbeA>() } -> std::same_as<const ProbeA&>;
    { constant.template find<ProbeA>() } -> std::same_as<const ProbeA*>;
    { constant.template contains<ProbeA>() } -> std::same_as<bool>;
};

} // namespace detail

// A registry of entities and their components. Beyond the signatures, a registry must keep these promises
// (docs/ecs.md):
//  - references to a component survive adding others of its type, but not removing one;
//  - each() does not visit entities that were added while it iterates, and destroying the current entity is legal;
//  - the order of each() follows the smallest pool: sort before any floating-point reduction;
//  - a destroyed entity's handle is not valid again when its slot is reused;
//  - ctx().emplace of a type that is there keeps the first value.
// Components are not empty types: EnTT leaves those out of each().
template <class R>
concept Registry = requires(R& registry, const R& constant, typename R::entity_type entity) {
    requires std::regular<typename R::entity_type>;
    requires std::totally_ordered<typename R::entity_type>;

    { registry.create() } -> std::same_as<typename R::entity_type>;
    registry.destroy(entity);
    { constant.valid(entity) } -> std::same_as<bool>;

    { registry.template emplace<detail::ProbeA>(entity, 1) } -> std::same_as<detail::ProbeA&>;
    { registry.template emplace_or_replace<detail::ProbeA>(entity, 1) } -> std::same_as<detail::ProbeA&>;
    { registry.template get<detail::ProbeA>(entity) } -> std::same_as<detail::ProbeA&>;
    { constant.template get<detail::ProbeA>(entity) } -> std::same_as<const detail::ProbeA&>;
    { registry.template try_get<detail::ProbeA>(entity) } -> std::same_as<detail::ProbeA*>;
    { constant.template try_get<detail::ProbeA>(entity) } -> std::same_as<const detail::ProbeA*>;
    { constant.template all_of<detail::ProbeA, detail::ProbeB>(entity) } -> std::same_as<bool>;
    { registry.template remove<detail::ProbeA>(entity) } -> std::convertible_to<std::size_t>;

    { registry.template view<detail::ProbeA>() } -> detail::ViewOf<typename R::entity_type, detail::ProbeA>;
    {
        registry.template view<detail::ProbeA, const detail::ProbeB>()
        } -> detail::ViewOf<typename R::entity_type, detail::ProbeA, const detail::ProbeB>;
    {
        constant.template view<const detail::ProbeA, const detail::ProbeB>()
        } -> detail::ViewOf<typename R::entity_type, const detail::ProbeA, const detail::ProbeB>;

    requires detail::Context<std::remove_reference_t<decltype(registry.ctx())>>;
    { constant.ctx().template find<detail::ProbeA>() } -> std::same_as<const detail::ProbeA*>;
};

} // namespace alpenglow
