// The registries that every test of a system runs on: ours, and EnTT's where the build found it.
//
//   template <class R> class Thing : public ::testing::Test {};
//   TYPED_TEST_SUITE(Thing, alpenglow::test::TestRegistries, alpenglow::test::RegistryNames);
//
// Link alpenglow_test_registries.
#pragma once

#include <alpenglow/ecs/registry.hpp>

#include <gtest/gtest.h>

#include <string>
#include <type_traits>

#ifdef ALPENGLOW_HAVE_ENTT
#include <entt/entity/registry.hpp>
#endif

namespace alpenglow::test {

#ifdef ALPENGLOW_HAVE_ENTT
static_assert(Registry<entt::registry>);
using TestRegistries = ::testing::Types<BasicRegistry, entt::registry>;
#else
using TestRegistries = ::testing::Types<BasicRegistry>;
#endif

// Names the typed tests "BasicRegistry" and "EnTT".
struct RegistryNames {
    template <class R>
    static std::string GetName(int /*index*/) {
        return std::is_same_v<R, BasicRegistry> ? "BasicRegistry" : "EnTT";
    }
};

} // namespace alpenglow::test
