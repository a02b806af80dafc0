#include <alpenglow/ecs/entity.hpp>
#include <alpenglow/ecs/registry.hpp>

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace alpenglow {
namespace {

TEST(EntityPool, TheValueInitialisedHandleIsNeverValid) {
    EntityPool pool;
    EXPECT_FALSE(pool.valid(Entity{}));
    const Entity first = pool.create();
    EXPECT_FALSE(pool.valid(Entity{}));
    pool.destroy(first);
    EXPECT_FALSE(pool.valid(Entity{}));
}

TEST(EntityPool, HandlesPackIndexAndVersion) {
    for (const std::uint32_t index : {0U, 1U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
        for (const std::uint32_t version : {0U, 1U, 0x80000000U, 0xFFFFFFFFU}) {
            EXPECT_EQ(entity_index(make_entity(index, version)), index);
            EXPECT_EQ(entity_version(make_entity(index, version)), version);
        }
    }
}

TEST(EntityPool, NoHandleMadeUpForAFreeSlotIsValid) {
    EntityPool pool;
    const Entity e = pool.create();
    pool.destroy(e);
    for (std::uint32_t version = 0; version < 16; ++version) {
        EXPECT_FALSE(pool.valid(make_entity(entity_index(e), version))) << version;
    }
}

TEST(EntityPool, ASlotWhoseVersionsAreSpentIsRetired) {
    EntityPool pool(7); // versions 1, 3, 5 and 7: four entities a slot
    std::set<Entity> given;
    for (int i = 0; i < 100; ++i) {
        const Entity e = pool.create();
        EXPECT_TRUE(given.insert(e).second) << "a handle was given out twice";
        EXPECT_EQ(entity_index(e), static_cast<std::uint32_t>(i / 4));
        pool.destroy(e);
        for (const Entity stale : given) {
            EXPECT_FALSE(pool.valid(stale));
        }
    }
}

TEST(EntityPool, TheLastVersionOfAllIsRetiredToo) {
    // A pool that starts at its last version: the increment after 2^32 - 1 would wrap to 0.
    EntityPool pool(1);
    const Entity first = pool.create();
    pool.destroy(first);
    const Entity second = pool.create();
    EXPECT_NE(entity_index(first), entity_index(second));
    EXPECT_FALSE(pool.valid(first));
    EXPECT_TRUE(pool.valid(second));
}

TEST(EntityPool, ARegistryKeepsComponentsApartAcrossRetirement) {
    BasicRegistry registry(EntityPool(3));
    std::vector<Entity> stale;
    for (int i = 0; i < 50; ++i) {
        const Entity e = registry.create();
        registry.emplace<int>(e, i);
        EXPECT_EQ(registry.get<int>(e), i);
        for (const Entity old : stale) {
            EXPECT_FALSE(registry.valid(old));
            EXPECT_EQ(registry.try_get<int>(old), nullptr);
        }
        registry.destroy(e);
        stale.push_back(e);
    }
}

} // namespace
} // namespace alpenglow
