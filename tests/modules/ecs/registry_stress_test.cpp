// Random operations against a simple model, and sizes past what a scene has.
#include "fp_traps.hpp"
#include "registries.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <type_traits>
#include <vector>

namespace alpenglow {
namespace {

struct A {
    std::uint64_t value;
};
struct B {
    std::unique_ptr<std::uint64_t> value; // a leak or a double free shows under the address sanitizer
};
struct C {
    std::uint32_t value;
    float rest[7];
};

// What the registry should hold.
struct Model {
    std::optional<std::uint64_t> a, b, c;
};

template <class R>
class RegistryStress : public test::StressTest {
protected:
    using Handle = typename R::entity_type;
    R registry;
    std::map<Handle, Model> model;
    std::vector<Handle> living;
    std::set<Handle> stale;
    std::mt19937_64 random{20260621};

    std::size_t below(std::size_t n) { return static_cast<std::size_t>(random() % n); }

    void create() {
        const Handle e = registry.create();
        ASSERT_EQ(model.count(e), 0U);
        ASSERT_EQ(stale.count(e), 0U) << "a destroyed entity's handle was given out again";
        model[e];
        living.push_back(e);
    }
    void forget(Handle e) {
        model.erase(e);
        living.erase(std::find(living.begin(), living.end(), e));
        stale.insert(e);
    }

    template <class T>
    T make(std::uint64_t value) {
        if constexpr (std::is_same_v<T, B>) {
            return B{std::make_unique<std::uint64_t>(value)};
        } else if constexpr (std::is_same_v<T, C>) {
            return C{static_cast<std::uint32_t>(value), {}};
        } else {
            return A{value};
        }
    }
    template <class T>
    void put(Handle e, std::optional<std::uint64_t>& slot) {
        const std::uint64_t value = random() & 0xFFFFFFFFU;
        if (slot || random() % 2 == 0) {
            registry.template emplace_or_replace<T>(e, make<T>(value));
        } else {
            registry.template emplace<T>(e, make<T>(value));
        }
        slot = value;
    }
    template <class T>
    void take(Handle e, std::optional<std::uint64_t>& slot) {
        ASSERT_EQ(registry.template remove<T>(e), slot ? 1U : 0U);
        slot.reset();
    }

    void check_all() {
        std::size_t a = 0;
        std::size_t ab = 0;
        std::size_t abc = 0;
        for (const auto& [e, m] : model) {
            ASSERT_TRUE(registry.valid(e));
            const A* pa = registry.template try_get<A>(e);
            const B* pb = registry.template try_get<B>(e);
            const C* pc = registry.template try_get<C>(e);
            ASSERT_EQ(pa != nullptr, m.a.has_value());
            ASSERT_EQ(pb != nullptr, m.b.has_value());
            ASSERT_EQ(pc != nullptr, m.c.has_value());
            if (pa != nullptr) {
                ASSERT_EQ(pa->value, *m.a);
            }
            if (pb != nullptr) {
                ASSERT_EQ(*pb->value, *m.b);
            }
            if (pc != nullptr) {
                ASSERT_EQ(pc->value, *m.c);
            }
            ASSERT_EQ((registry.template all_of<A, B, C>(e)), m.a && m.b && m.c);
            a += m.a ? 1 : 0;
            ab += m.a && m.b ? 1 : 0;
            abc += m.a && m.b && m.c ? 1 : 0;
        }
        for (const Handle e : stale) {
            ASSERT_FALSE(registry.valid(e));
            ASSERT_EQ(registry.template try_get<A>(e), nullptr);
        }
        std::size_t seen_a = 0;
        std::size_t seen_ab = 0;
        std::size_t seen_abc = 0;
        registry.template view<A>().each([&](Handle e, A& x) {
            ++seen_a;
            EXPECT_EQ(x.value, model.at(e).a);
        });
        for (auto [e, x, y] : std::as_const(registry).template view<const A, const B>().each()) {
            ++seen_ab;
            EXPECT_EQ(x.value, model.at(e).a);
            EXPECT_EQ(*y.value, model.at(e).b);
        }
        registry.template view<C, B, A>().each([&](Handle e, C& z, B&, A&) {
            ++seen_abc;
            EXPECT_EQ(z.value, model.at(e).c);
        });
        ASSERT_EQ(seen_a, a);
        ASSERT_EQ(seen_ab, ab);
        ASSERT_EQ(seen_abc, abc);
    }
};
TYPED_TEST_SUITE(RegistryStress, test::TestRegistries, test::RegistryNames);

TYPED_TEST(RegistryStress, RandomOperationsMatchAModel) {
    for (int step = 0; step < 60'000; ++step) {
        // The population grows and shrinks in turns, down to nothing.
        const bool growing = step / 3000 % 2 == 0;
        const std::size_t choice = this->below(100);
        if (this->living.empty() || choice < (growing ? 20U : 5U)) {
            this->create();
        } else {
            const auto e = this->living[this->below(this->living.size())];
            Model& m = this->model.at(e);
            if (choice < 28) {
                this->registry.destroy(e);
                this->forget(e);
            } else if (choice < 45) {
                this->template put<A>(e, m.a);
            } else if (choice < 62) {
                this->template put<B>(e, m.b);
            } else if (choice < 79) {
                this->template put<C>(e, m.c);
            } else if (choice < 86) {
                this->template take<A>(e, m.a);
            } else if (choice < 93) {
                this->template take<B>(e, m.b);
            } else {
                this->template take<C>(e, m.c);
            }
        }
        if (step % 2500 == 0) {
            this->check_all();
        }
        if (this->HasFatalFailure()) {
            return;
        }
    }
    this->check_all();
}

TYPED_TEST(RegistryStress, RandomChangesWhileIteratingMatchAModel) {
    using E = typename TypeParam::entity_type;
    for (int i = 0; i < 2000; ++i) {
        this->create();
        const E e = this->living.back();
        this->template put<A>(e, this->model.at(e).a);
        if (i % 4 != 0) {
            this->template put<B>(e, this->model.at(e).b);
        }
    }
    for (int round = 0; round < 30; ++round) {
        std::set<E> expected;
        for (const auto& [e, m] : this->model) {
            if (m.a && m.b) {
                expected.insert(e);
            }
        }
        std::set<E> visited;
        const auto visit = [&](E e) {
            ASSERT_TRUE(visited.insert(e).second);
            switch (this->below(4)) {
            case 0:
                this->registry.destroy(e);
                this->forget(e);
                break;
            case 1:
                this->template take<B>(e, this->model.at(e).b);
                break;
            case 2: {
                this->create();
                const E added = this->living.back();
                this->template put<B>(added, this->model.at(added).b);
                this->template put<A>(added, this->model.at(added).a);
                break;
            }
            default:
                this->template put<C>(e, this->model.at(e).c);
            }
        };
        if (round % 2 == 0) {
            this->registry.template view<A, B>().each([&](E e, A&, B&) { visit(e); });
        } else {
            for (auto [e, a, b] : this->registry.template view<A, B>().each()) {
                visit(e);
            }
        }
        ASSERT_EQ(visited, expected) << "round " << round;
        this->check_all();
        while (this->living.size() < 2000) { // refill
            this->create();
            const E e = this->living.back();
            this->template put<A>(e, this->model.at(e).a);
            this->template put<B>(e, this->model.at(e).b);
        }
    }
}

TYPED_TEST(RegistryStress, AMillionEntities) {
    using E = typename TypeParam::entity_type;
    constexpr std::uint32_t n = 1'000'000; // EnTT's default handle counts to 2^20 - 1
    std::vector<E> entities;
    entities.reserve(n);
    std::uint64_t sum = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const E e = this->registry.create();
        entities.push_back(e);
        this->registry.template emplace<A>(e, std::uint64_t{i});
        sum += i;
    }
    std::shuffle(entities.begin(), entities.end(), this->random);
    for (std::uint32_t i = 0; i < n / 2; ++i) {
        sum -= this->registry.template get<A>(entities[i]).value;
        this->registry.destroy(entities[i]);
    }
    std::uint64_t seen = 0;
    std::size_t count = 0;
    this->registry.template view<const A>().each([&](E, const A& a) {
        seen += a.value;
        ++count;
    });
    EXPECT_EQ(count, n - n / 2);
    EXPECT_EQ(seen, sum);
    for (std::uint32_t i = 0; i < n / 2; ++i) {
        const E e = this->registry.create();
        EXPECT_NE(e, entities[i]);
    }
    for (std::uint32_t i = 0; i < n / 2; ++i) {
        ASSERT_FALSE(this->registry.valid(entities[i]));
    }
}

TEST(BasicRegistryStress, FourMillionEntitiesPastThePeersLimit) {
    BasicRegistry registry;
    constexpr std::uint32_t n = 4'000'000;
    Entity last{};
    for (std::uint32_t i = 0; i < n; ++i) {
        last = registry.create();
        if (i % 1000 == 999) {
            registry.emplace<A>(last, std::uint64_t{i});
        }
    }
    EXPECT_EQ(entity_index(last), n - 1);
    EXPECT_EQ(registry.get<A>(last).value, n - 1);
    std::size_t count = 0;
    registry.view<A>().each([&](Entity, A&) { ++count; });
    EXPECT_EQ(count, n / 1000);
}

TEST(BasicRegistryStress, SlotsThatWearOutUnderRandomOperations) {
    // A slot lives for two entities only: retirement all the time.
    BasicRegistry registry(EntityPool(3));
    std::mt19937 random(7);
    std::vector<Entity> living;
    std::set<Entity> given;
    for (int step = 0; step < 50'000; ++step) {
        if (living.empty() || random() % 2 == 0) {
            living.push_back(registry.create());
            ASSERT_TRUE(given.insert(living.back()).second);
            registry.emplace<A>(living.back(), static_cast<std::uint64_t>(living.back()));
        } else {
            const std::size_t i = random() % living.size();
            ASSERT_EQ(registry.get<A>(living[i]).value, static_cast<std::uint64_t>(living[i]));
            registry.destroy(living[i]);
            ASSERT_FALSE(registry.valid(living[i]));
            living[i] = living.back();
            living.pop_back();
        }
    }
    std::size_t count = 0;
    registry.view<A>().each([&](Entity e, A& a) {
        EXPECT_EQ(a.value, static_cast<std::uint64_t>(e));
        ++count;
    });
    EXPECT_EQ(count, living.size());
}

} // namespace
} // namespace alpenglow
