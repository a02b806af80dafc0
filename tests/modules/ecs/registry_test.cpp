// The semantics that games rely on, on every registry that the build has.
#include "registries.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace alpenglow {
namespace {

struct Position {
    float x = 0.0F;
    float y = 0.0F;
};
struct Velocity {
    float x = 0.0F;
    float y = 0.0F;
};
struct Mass {
    double kg = 1.0;
};
struct Name { // not trivially copyable, and no aggregate
    explicit Name(std::string name) : text(std::move(name)) {}
    std::string text;
};
struct MoveOnly {
    std::unique_ptr<int> value;
};
struct alignas(64) Aligned {
    float lanes[16] = {};
};
struct Huge {
    std::array<std::byte, 100'000> bytes{};
};

template <class R>
class RegistryTest : public ::testing::Test {
protected:
    using Entity = typename R::entity_type;
    R registry;

    Entity with_position(float x) {
        const Entity e = registry.create();
        registry.template emplace<Position>(e, x, 0.0F);
        return e;
    }
};
TYPED_TEST_SUITE(RegistryTest, test::TestRegistries, test::RegistryNames);

// Entities

TYPED_TEST(RegistryTest, CreatedEntitiesAreDistinctAndValid) {
    std::set<typename TypeParam::entity_type> entities;
    for (int i = 0; i < 10'000; ++i) {
        const auto e = this->registry.create();
        EXPECT_TRUE(entities.insert(e).second);
    }
    for (const auto e : entities) {
        EXPECT_TRUE(this->registry.valid(e));
    }
}

TYPED_TEST(RegistryTest, HandlesThatWereNeverGivenOutAreInvalid) {
    using E = typename TypeParam::entity_type;
    const E far = static_cast<E>(std::numeric_limits<std::underlying_type_t<E>>::max());
    EXPECT_FALSE(this->registry.valid(far));
    EXPECT_FALSE(this->registry.valid(static_cast<E>(12345)));
    static_cast<void>(this->registry.create());
    EXPECT_FALSE(this->registry.valid(far));
    EXPECT_FALSE(this->registry.valid(static_cast<E>(12345)));
}

TYPED_TEST(RegistryTest, AStaleHandleStaysInvalidWhenItsSlotIsReused) {
    std::vector<typename TypeParam::entity_type> stale;
    for (int i = 0; i < 2000; ++i) {
        const auto e = this->with_position(1.0F);
        EXPECT_TRUE(this->registry.valid(e));
        this->registry.destroy(e);
        stale.push_back(e);
    }
    const auto living = this->with_position(2.0F);
    for (const auto e : stale) {
        EXPECT_NE(e, living);
        EXPECT_FALSE(this->registry.valid(e));
        EXPECT_FALSE(this->registry.template all_of<Position>(e));
        EXPECT_EQ(this->registry.template try_get<Position>(e), nullptr);
    }
}

TYPED_TEST(RegistryTest, DestroyTakesEveryComponent) {
    const auto e = this->with_position(1.0F);
    this->registry.template emplace<Velocity>(e, 1.0F, 2.0F);
    this->registry.template emplace<Name>(e, "gone");
    this->registry.destroy(e);
    std::size_t left = 0;
    this->registry.template view<Position>().each([&](auto, Position&) { ++left; });
    this->registry.template view<Velocity>().each([&](auto, Velocity&) { ++left; });
    this->registry.template view<Name>().each([&](auto, Name&) { ++left; });
    EXPECT_EQ(left, 0U);
}

// Components

TYPED_TEST(RegistryTest, ComponentsAreFoundAgain) {
    const auto e = this->registry.create();
    const auto other = this->registry.create();
    TypeParam& writable = this->registry;
    const TypeParam& constant = writable;
    EXPECT_FALSE(constant.template all_of<Position>(e));
    EXPECT_EQ(constant.template try_get<Position>(e), nullptr);
    Position& made = writable.template emplace<Position>(e, 1.0F, 2.0F);
    EXPECT_EQ(&made, &writable.template get<Position>(e));
    EXPECT_EQ(&made, &constant.template get<Position>(e));
    EXPECT_EQ(&made, writable.template try_get<Position>(e));
    EXPECT_EQ(&made, constant.template try_get<Position>(e));
    EXPECT_EQ(made.y, 2.0F);
    EXPECT_TRUE(constant.template all_of<Position>(e));
    EXPECT_FALSE((constant.template all_of<Position, Velocity>(e)));
    writable.template emplace<Velocity>(e);
    EXPECT_TRUE((constant.template all_of<Position, Velocity>(e)));
    EXPECT_FALSE(constant.template all_of<Position>(other));
    EXPECT_EQ(writable.template try_get<Position>(other), nullptr);
}

TYPED_TEST(RegistryTest, ConstAccessGivesConst) {
    using R = TypeParam;
    static_assert(std::is_same_v<decltype(std::declval<R&>().template get<const Position>({})), const Position&>);
    static_assert(std::is_same_v<decltype(std::declval<R&>().template try_get<const Position>({})), const Position*>);
    static_assert(std::is_same_v<decltype(std::declval<const R&>().template get<Position>({})), const Position&>);
    const auto e = this->with_position(3.0F);
    EXPECT_EQ(this->registry.template get<const Position>(e).x, 3.0F);
}

TYPED_TEST(RegistryTest, EmplaceOrReplaceReplacesInPlace) {
    const auto e = this->registry.create();
    Position& first = this->registry.template emplace_or_replace<Position>(e, 1.0F, 2.0F);
    Position& second = this->registry.template emplace_or_replace<Position>(e, 3.0F);
    EXPECT_EQ(&first, &second);
    EXPECT_EQ(second.x, 3.0F);
    EXPECT_EQ(second.y, 0.0F); // the rest of the aggregate is made anew
    this->registry.template emplace_or_replace<Name>(e, "a");
    this->registry.template emplace_or_replace<Name>(e, "b");
    EXPECT_EQ(this->registry.template get<Name>(e).text, "b");
}

TYPED_TEST(RegistryTest, EmplaceTakesAWholeValue) {
    const auto e = this->registry.create();
    const Position p{4.0F, 5.0F};
    EXPECT_EQ(this->registry.template emplace<Position>(e, p).y, 5.0F);
    EXPECT_EQ(*this->registry.template emplace<MoveOnly>(e, std::make_unique<int>(7)).value, 7);
}

TYPED_TEST(RegistryTest, RemoveCountsAndIsIdempotent) {
    const auto e = this->with_position(1.0F);
    EXPECT_EQ(this->registry.template remove<Velocity>(e), 0U);
    EXPECT_EQ(this->registry.template remove<Position>(e), 1U);
    EXPECT_EQ(this->registry.template remove<Position>(e), 0U);
    EXPECT_FALSE(this->registry.template all_of<Position>(e));
    EXPECT_TRUE(this->registry.valid(e));
    this->registry.template emplace<Position>(e, 9.0F);
    EXPECT_EQ(this->registry.template get<Position>(e).x, 9.0F);
}

TYPED_TEST(RegistryTest, RemovalKeepsTheOthersValues) {
    std::vector<typename TypeParam::entity_type> entities;
    for (int i = 0; i < 3000; ++i) {
        entities.push_back(this->registry.create());
        this->registry.template emplace<Name>(entities.back(), std::to_string(i));
    }
    for (std::size_t i = 0; i < entities.size(); i += 3) {
        this->registry.template remove<Name>(entities[i]);
    }
    for (std::size_t i = 0; i < entities.size(); ++i) {
        const Name* name = this->registry.template try_get<Name>(entities[i]);
        ASSERT_EQ(name != nullptr, i % 3 != 0);
        if (name != nullptr) {
            EXPECT_EQ(name->text, std::to_string(i));
        }
    }
}

TYPED_TEST(RegistryTest, ReferencesSurviveAddingToTheSamePool) {
    const auto e = this->registry.create();
    Name& name = this->registry.template emplace<Name>(e, "stays");
    for (int i = 0; i < 100'000; ++i) {
        this->registry.template emplace<Name>(this->registry.create(), "another");
    }
    EXPECT_EQ(&name, &this->registry.template get<Name>(e));
    EXPECT_EQ(name.text, "stays");
}

TYPED_TEST(RegistryTest, AComponentCanBeMadeFromAnotherOfItsPool) {
    auto last = this->registry.create();
    this->registry.template emplace<Name>(last, "copied");
    for (int i = 0; i < 5000; ++i) {
        const auto next = this->registry.create();
        this->registry.template emplace<Name>(next, this->registry.template get<Name>(last));
        last = next;
    }
    EXPECT_EQ(this->registry.template get<Name>(last).text, "copied");
}

TYPED_TEST(RegistryTest, AlignmentAndSizeOfComponentsAreKept) {
    for (int i = 0; i < 1000; ++i) {
        const auto e = this->registry.create();
        const Aligned& aligned = this->registry.template emplace<Aligned>(e);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&aligned) % alignof(Aligned), 0U);
    }
    std::vector<typename TypeParam::entity_type> huge;
    for (int i = 0; i < 5; ++i) {
        huge.push_back(this->registry.create());
        this->registry.template emplace<Huge>(huge.back()).bytes.back() = static_cast<std::byte>(i);
    }
    this->registry.destroy(huge[1]);
    EXPECT_EQ(this->registry.template get<Huge>(huge[4]).bytes.back(), std::byte{4});
}

TYPED_TEST(RegistryTest, ComponentsAreDestroyedOnceEach) {
    const auto count = std::make_shared<int>(0);
    struct Held {
        std::shared_ptr<int> count;
    };
    {
        TypeParam fresh;
        std::vector<typename TypeParam::entity_type> entities;
        for (int i = 0; i < 100; ++i) {
            entities.push_back(fresh.create());
            fresh.template emplace<Held>(entities.back(), count);
        }
        EXPECT_EQ(count.use_count(), 101);
        for (std::size_t i = 0; i < 50; ++i) {
            fresh.destroy(entities[2 * i]);
        }
        EXPECT_EQ(count.use_count(), 51);
        fresh.template remove<Held>(entities[1]);
        EXPECT_EQ(count.use_count(), 50);
    }
    EXPECT_EQ(count.use_count(), 1);
}

TYPED_TEST(RegistryTest, ARegistryMoves) {
    const auto e = this->with_position(1.0F);
    Position& position = this->registry.template get<Position>(e);
    this->registry.ctx().template emplace<Mass>(5.0);
    TypeParam moved = std::move(this->registry);
    EXPECT_TRUE(moved.valid(e));
    EXPECT_EQ(&moved.template get<Position>(e), &position);
    EXPECT_EQ(moved.ctx().template get<Mass>().kg, 5.0);
}

// Views

TYPED_TEST(RegistryTest, AViewVisitsExactlyTheEntitiesThatHaveAll) {
    using E = typename TypeParam::entity_type;
    std::set<E> expected;
    for (int i = 0; i < 10'000; ++i) {
        const E e = this->registry.create();
        if (i % 2 == 0) {
            this->registry.template emplace<Position>(e, static_cast<float>(i));
        }
        if (i % 3 == 0) {
            this->registry.template emplace<Velocity>(e, static_cast<float>(i));
        }
        if (i % 5 == 0) {
            this->registry.template emplace<Mass>(e, static_cast<double>(i));
        }
        if (i % 30 == 0) {
            expected.insert(e);
        }
    }
    std::set<E> called;
    this->registry.template view<Position, Velocity, Mass>().each([&](E e, Position& p, Velocity& v, Mass& m) {
        EXPECT_TRUE(called.insert(e).second);
        EXPECT_EQ(p.x, v.x);
        EXPECT_EQ(static_cast<double>(p.x), m.kg);
        EXPECT_EQ(&p, &this->registry.template get<Position>(e));
    });
    EXPECT_EQ(called, expected);
    std::set<E> ranged;
    for (auto [e, p, v, m] : this->registry.template view<Position, Velocity, Mass>().each()) {
        static_assert(std::is_same_v<decltype(p), Position&>);
        EXPECT_TRUE(ranged.insert(e).second);
        EXPECT_EQ(&m, &this->registry.template get<Mass>(e));
        EXPECT_EQ(p.x, v.x);
    }
    EXPECT_EQ(ranged, expected);
}

TYPED_TEST(RegistryTest, AViewWritesThroughItsReferences) {
    const auto e = this->with_position(1.0F);
    this->registry.template emplace<Velocity>(e, 10.0F);
    for (auto [entity, p, v] : this->registry.template view<Position, const Velocity>().each()) {
        p.x += v.x;
    }
    this->registry.template view<Position, const Velocity>().each(
        [](auto, Position& p, const Velocity& v) { p.x += v.x; });
    EXPECT_EQ(this->registry.template get<Position>(e).x, 21.0F);
}

TYPED_TEST(RegistryTest, ConstRegistriesAndConstViews) {
    const auto e = this->with_position(1.0F);
    this->registry.template emplace<Velocity>(e, 2.0F);
    const TypeParam& constant = this->registry;
    int visited = 0;
    for (auto [entity, p] : constant.template view<const Position>().each()) {
        static_assert(std::is_same_v<decltype(p), const Position&>);
        EXPECT_EQ(entity, e);
        EXPECT_EQ(p.x, 1.0F);
        ++visited;
    }
    const auto view = constant.template view<const Position, const Velocity>();
    view.each([&](auto entity, const Position& p, const Velocity& v) {
        EXPECT_EQ(entity, e);
        EXPECT_EQ(p.x + v.x, 3.0F);
        ++visited;
    });
    for (auto [entity, p, v] : view.each()) {
        static_assert(std::is_same_v<decltype(v), const Velocity&>);
        ++visited;
    }
    for (auto [entity, p] : this->registry.template view<const Position>().each()) {
        static_assert(std::is_same_v<decltype(p), const Position&>);
        ++visited;
    }
    EXPECT_EQ(visited, 4);
}

TYPED_TEST(RegistryTest, ViewsOfNothingAreEmpty) {
    const TypeParam& constant = this->registry;
    int visited = 0;
    const auto count = [&](auto, auto&...) { ++visited; };
    constant.template view<const Position>().each(count); // no pool yet
    constant.template view<const Position, const Velocity>().each(count);
    for (const auto& row : constant.template view<const Position, const Velocity>().each()) {
        count(std::get<0>(row), std::get<1>(row));
    }
    this->registry.template view<Position, Velocity>().each(count);
    this->with_position(1.0F);
    constant.template view<const Position, const Velocity>().each(count);
    this->registry.template view<Position, Velocity>().each(count);
    for (const auto& row : this->registry.template view<Position, Velocity>().each()) {
        count(std::get<0>(row), std::get<1>(row));
    }
    EXPECT_EQ(visited, 0);
}

TYPED_TEST(RegistryTest, AViewKeptFromBeforeSeesWhatCameAfter) {
    const auto view = this->registry.template view<Position>();
    const auto e = this->with_position(1.0F);
    int visited = 0;
    view.each([&](auto entity, Position&) {
        EXPECT_EQ(entity, e);
        ++visited;
    });
    EXPECT_EQ(visited, 1);
}

TYPED_TEST(RegistryTest, TheSmallestPoolLeads) {
    // The order of a view is that of its smallest pool, which was filled in another order than the larger one.
    using E = typename TypeParam::entity_type;
    std::vector<E> entities;
    for (int i = 0; i < 1000; ++i) {
        entities.push_back(this->with_position(static_cast<float>(i)));
    }
    for (const std::size_t i : {500U, 3U, 999U, 42U, 7U}) {
        this->registry.template emplace<Velocity>(entities[i]);
    }
    std::vector<E> alone;
    this->registry.template view<Velocity>().each([&](E e, Velocity&) { alone.push_back(e); });
    std::vector<E> called;
    this->registry.template view<Position, Velocity>().each([&](E e, Position&, Velocity&) { called.push_back(e); });
    std::vector<E> ranged;
    for (auto [e, v, p] : this->registry.template view<Velocity, Position>().each()) {
        ranged.push_back(e);
    }
    EXPECT_EQ(alone.size(), 5U);
    EXPECT_EQ(called, alone);
    EXPECT_EQ(ranged, alone);
}

// Changes while iterating

TYPED_TEST(RegistryTest, EntitiesAddedWhileIteratingAreNotVisited) {
    for (int i = 0; i < 3000; ++i) {
        this->with_position(1.0F);
    }
    int called = 0;
    this->registry.template view<Position>().each([&](auto, Position& p) {
        EXPECT_EQ(p.x, 1.0F);
        this->with_position(2.0F);
        EXPECT_EQ(p.x, 1.0F); // the reference survives
        ++called;
    });
    EXPECT_EQ(called, 3000);
    int ranged = 0;
    for (auto [e, p] : this->registry.template view<Position>().each()) {
        this->with_position(3.0F);
        EXPECT_NE(p.x, 3.0F);
        ++ranged;
    }
    EXPECT_EQ(ranged, 6000);
}

TYPED_TEST(RegistryTest, EntitiesAddedWhileIteratingSeveralTypesAreNotVisited) {
    const auto add = [&](float x) {
        const auto e = this->with_position(x);
        this->registry.template emplace<Velocity>(e);
    };
    for (int i = 0; i < 3000; ++i) {
        add(1.0F);
        this->with_position(0.0F);
    }
    int visited = 0;
    this->registry.template view<Position, Velocity>().each([&](auto, Position& p, Velocity&) {
        EXPECT_EQ(p.x, 1.0F);
        add(2.0F);
        ++visited;
    });
    EXPECT_EQ(visited, 3000);
    for (auto [e, p, v] : this->registry.template view<Position, Velocity>().each()) {
        EXPECT_NE(p.x, 3.0F);
        add(3.0F);
        ++visited;
    }
    EXPECT_EQ(visited, 9000);
}

TYPED_TEST(RegistryTest, DestroyingTheCurrentEntityIsLegal) {
    using E = typename TypeParam::entity_type;
    for (const bool ranged : {false, true}) {
        for (const bool two_types : {false, true}) {
            TypeParam fresh;
            std::set<E> all;
            for (int i = 0; i < 5000; ++i) {
                const E e = fresh.create();
                fresh.template emplace<Position>(e, static_cast<float>(i));
                fresh.template emplace<Velocity>(e, static_cast<float>(i));
                all.insert(e);
            }
            std::multiset<E> visited;
            std::set<E> destroyed;
            const auto visit = [&](E e, float x) {
                visited.insert(e);
                if (static_cast<int>(x) % 3 != 1) {
                    fresh.destroy(e);
                    destroyed.insert(e);
                }
            };
            if (ranged && two_types) {
                for (auto [e, p, v] : fresh.template view<Position, Velocity>().each()) {
                    visit(e, p.x);
                }
            } else if (ranged) {
                for (auto [e, p] : fresh.template view<Position>().each()) {
                    visit(e, p.x);
                }
            } else if (two_types) {
                fresh.template view<Position, Velocity>().each([&](E e, Position& p, Velocity&) { visit(e, p.x); });
            } else {
                fresh.template view<Position>().each([&](E e, Position& p) { visit(e, p.x); });
            }
            EXPECT_EQ(visited, std::multiset<E>(all.begin(), all.end())) << "each once, none left out";
            for (const E e : all) {
                EXPECT_EQ(fresh.valid(e), destroyed.count(e) == 0);
            }
            std::size_t left = 0;
            fresh.template view<Position>().each([&](E, Position&) { ++left; });
            EXPECT_EQ(left, all.size() - destroyed.size());
        }
    }
}

TYPED_TEST(RegistryTest, RemovingTheCurrentComponentWhileIteratingIsLegal) {
    for (int i = 0; i < 3000; ++i) {
        this->registry.template emplace<Velocity>(this->with_position(static_cast<float>(i)));
    }
    int visited = 0;
    this->registry.template view<Position, Velocity>().each([&](auto e, Position&, Velocity&) {
        this->registry.template remove<Velocity>(e);
        ++visited;
    });
    EXPECT_EQ(visited, 3000);
    this->registry.template view<Velocity>().each([&](auto, Velocity&) { ++visited; });
    EXPECT_EQ(visited, 3000);
}

TYPED_TEST(RegistryTest, TypesFirstSeenWhileIteratingAreLegal) {
    struct Late {
        int value;
    };
    for (int i = 0; i < 100; ++i) {
        this->with_position(1.0F);
    }
    for (auto [e, p] : this->registry.template view<Position>().each()) {
        this->registry.template emplace<Late>(e, 1);
    }
    int late = 0;
    this->registry.template view<Late, Position>().each([&](auto, Late& l, Position&) { late += l.value; });
    EXPECT_EQ(late, 100);
}

// Context

TYPED_TEST(RegistryTest, TheContextKeepsTheFirstValue) {
    auto& ctx = this->registry.ctx();
    EXPECT_FALSE(ctx.template contains<Mass>());
    EXPECT_EQ(ctx.template find<Mass>(), nullptr);
    Mass& mass = ctx.template emplace<Mass>(1.0);
    EXPECT_EQ(&ctx.template emplace<Mass>(2.0), &mass);
    EXPECT_EQ(mass.kg, 1.0);
    EXPECT_TRUE(ctx.template contains<Mass>());
    EXPECT_EQ(ctx.template find<Mass>(), &mass);
    EXPECT_EQ(&ctx.template get<Mass>(), &mass);
    ctx.template get<Mass>().kg = 3.0;
    const auto& constant = std::as_const(this->registry).ctx();
    EXPECT_EQ(constant.template get<Mass>().kg, 3.0);
    EXPECT_EQ(constant.template find<Mass>(), &mass);
    EXPECT_EQ(constant.template find<Position>(), nullptr);
    EXPECT_FALSE(constant.template contains<Position>());
}

TYPED_TEST(RegistryTest, TheContextHoldsAnyTypeAndItsReferencesStay) {
    auto& ctx = this->registry.ctx();
    Name& name = ctx.template emplace<Name>("first");
    ctx.template emplace<MoveOnly>(std::make_unique<int>(3));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&ctx.template emplace<Aligned>()) % alignof(Aligned), 0U);
    ctx.template emplace<std::vector<int>>(std::size_t{4}, 9);
    ctx.template emplace<int>(1);
    ctx.template emplace<double>(2.0);
    EXPECT_EQ(&name, &ctx.template get<Name>());
    EXPECT_EQ(name.text, "first");
    EXPECT_EQ(*ctx.template get<MoveOnly>().value, 3);
    EXPECT_EQ(ctx.template get<std::vector<int>>(), std::vector<int>(4, 9));
    // The context and the components are apart.
    int visited = 0;
    this->registry.template view<Name>().each([&](auto, Name&) { ++visited; });
    EXPECT_EQ(visited, 0);
}

} // namespace
} // namespace alpenglow
