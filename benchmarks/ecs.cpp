// The registry against plain arrays: iteration, random access, creation and destruction. Each row checks that it
// computed the same as the arrays.
#include "bench.hpp"

#include <alpenglow/ecs/registry.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace alpenglow::bench {
namespace {

struct Position {
    float x, y, z;
};
struct Velocity {
    float x, y, z;
};
struct Energy {
    float joule;
};

constexpr float dt = 1e-3F;

inline void sum_step(double& sum, const Position& p) {
    sum += static_cast<double>(p.x);
}
inline void move_step(Position& p) {
    p.x += dt;
    p.y -= dt;
    p.z += 2.0F * dt;
}
inline void drive_step(Position& p, const Velocity& v, Energy& e) {
    p.x += v.x * dt;
    p.y += v.y * dt;
    p.z += v.z * dt;
    e.joule += dt * (v.x * v.x + v.y * v.y + v.z * v.z);
}

// The same entities' components as arrays, with the i-th entity's components at i.
struct Arrays {
    std::vector<Position> position;
    std::vector<Velocity> velocity;
    std::vector<Energy> energy;
};

// A registry of n entities and its twin in arrays. Each pool is filled in the order of the entities or in one of its
// own.
struct World {
    World(std::size_t n, bool shuffled) : order_v(n), order_e(n) {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
        for (std::size_t i = 0; i < n; ++i) {
            entities.push_back(registry.create());
            arrays.position.push_back({uniform(random), uniform(random), uniform(random)});
            arrays.velocity.push_back({uniform(random), uniform(random), uniform(random)});
            arrays.energy.push_back({0.0F});
        }
        std::vector<std::uint32_t> order_p(n);
        for (auto* order : {&order_p, &order_v, &order_e}) {
            std::iota(order->begin(), order->end(), 0U);
            if (shuffled) {
                std::shuffle(order->begin(), order->end(), random);
            }
        }
        for (const std::uint32_t i : order_p) {
            registry.emplace<Position>(entities[i], arrays.position[i]);
        }
        for (const std::uint32_t i : order_v) {
            registry.emplace<Velocity>(entities[i], arrays.velocity[i]);
        }
        for (const std::uint32_t i : order_e) {
            registry.emplace<Energy>(entities[i], arrays.energy[i]);
        }
    }

    // Largest absolute difference between registry and arrays.
    [[nodiscard]] double difference() const {
        double worst = 0.0;
        for (std::size_t i = 0; i < entities.size(); ++i) {
            const Position& p = registry.get<Position>(entities[i]);
            const Position& q = arrays.position[i];
            for (const float d :
                 {p.x - q.x, p.y - q.y, p.z - q.z, registry.get<Energy>(entities[i]).joule - arrays.energy[i].joule}) {
                worst = std::max(worst, static_cast<double>(std::fabs(d)));
            }
        }
        return worst;
    }

    BasicRegistry registry;
    std::vector<Entity> entities;
    Arrays arrays;
    std::vector<std::uint32_t> order_v;
    std::vector<std::uint32_t> order_e;
};

Row row(std::string name, std::string method, std::size_t n, std::string metric, double error = 0.0) {
    Row r;
    r.module = "ecs";
    r.name = std::move(name);
    r.method = std::move(method);
    r.error = error;
    r.error_metric = std::move(metric);
    r.reference = "plain arrays";
    r.items = static_cast<double>(n);
    return r;
}

constexpr std::size_t million = 1'000'000;

std::size_t entity_count(const Context& context) {
    return context.quick() ? 20'000 : million;
}

std::string with_count(const char* what, std::size_t n) {
    return std::string(what) + ", " + std::to_string(n);
}

void iterate_one(const Context& context) {
    const std::size_t n = entity_count(context);
    const auto world = std::make_unique<World>(n, false);
    Arrays& arrays = world->arrays;
    BasicRegistry& registry = world->registry;

    const auto sum_arrays = [&] {
        double sum = 0.0;
        for (std::size_t i = n; i-- > 0;) {
            sum_step(sum, arrays.position[i]);
        }
        return sum;
    };
    const auto sum_each = [&] {
        double sum = 0.0;
        registry.view<const Position>().each([&](Entity, const Position& p) { sum_step(sum, p); });
        return sum;
    };
    const auto sum_range = [&] {
        double sum = 0.0;
        for (auto [e, p] : registry.view<const Position>().each()) {
            sum_step(sum, p);
        }
        return sum;
    };
    const char* const sums = "absolute difference of the sums in the same order";
    const std::string read = with_count("iterate 1 component, sum", n);
    context.run(row(read, "plain array", n, sums), [&] { keep(sum_arrays()); });
    context.run(row(read, "each(fn)", n, sums, std::fabs(sum_each() - sum_arrays())), [&] { keep(sum_each()); });
    context.run(row(read, "each() range", n, sums, std::fabs(sum_range() - sum_arrays())), [&] { keep(sum_range()); });

    const auto move_arrays = [&] {
        for (Position& p : arrays.position) {
            move_step(p);
        }
        keep(arrays.position.data());
    };
    const auto move_each = [&] { registry.view<Position>().each([](Entity, Position& p) { move_step(p); }); };
    const auto move_range = [&] {
        for (auto [e, p] : registry.view<Position>().each()) {
            move_step(p);
        }
    };
    move_arrays();
    move_each();
    const double each_error = world->difference();
    move_arrays();
    move_range();
    const double range_error = world->difference();
    const char* const values = "max absolute difference of all values after one update each";
    const std::string write = with_count("iterate 1 component, update", n);
    context.run(row(write, "plain array", n, values), move_arrays);
    context.run(row(write, "each(fn)", n, values, each_error), move_each);
    context.run(row(write, "each() range", n, values, range_error), move_range);
}

void iterate_three(const Context& context, bool shuffled) {
    const std::size_t n = entity_count(context);
    const auto world = std::make_unique<World>(n, shuffled);
    Arrays& arrays = world->arrays;
    BasicRegistry& registry = world->registry;

    const auto drive_arrays = [&] {
        for (std::size_t i = 0; i < n; ++i) {
            drive_step(arrays.position[i], arrays.velocity[i], arrays.energy[i]);
        }
        keep(arrays.position.data());
    };
    const auto drive_each = [&] {
        registry.view<Position, const Velocity, Energy>().each(
            [](Entity, Position& p, const Velocity& v, Energy& e) { drive_step(p, v, e); });
    };
    const auto drive_range = [&] {
        for (auto [entity, p, v, e] : registry.view<Position, const Velocity, Energy>().each()) {
            drive_step(p, v, e);
        }
    };
    drive_arrays();
    drive_each();
    const double each_error = world->difference();
    drive_arrays();
    drive_range();
    const double range_error = world->difference();
    const char* const values = "max absolute difference of all values after one update each";
    const std::string name =
        with_count(shuffled ? "iterate 3 components, pools shuffled" : "iterate 3 components, pools in step", n);
    context.run(row(name, "plain arrays", n, values), drive_arrays);
    if (shuffled) {
        // What the memory charges for the disorder itself: arrays reached through two random permutations.
        const auto drive_indexed = [&] {
            for (std::size_t i = 0; i < n; ++i) {
                drive_step(arrays.position[i], arrays.velocity[world->order_v[i]], arrays.energy[world->order_e[i]]);
            }
            keep(arrays.position.data());
        };
        context.run(row(name, "plain arrays through shuffled indices", n, "the same work on other pairs"),
                    drive_indexed);
    }
    context.run(row(name, "each(fn)", n, values, each_error), drive_each);
    context.run(row(name, "each() range", n, values, range_error), drive_range);
}

void access(const Context& context) {
    const std::size_t n = entity_count(context);
    const auto world = std::make_unique<World>(n, false);
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0U);
    std::shuffle(order.begin(), order.end(), std::mt19937(2));
    std::vector<Entity> shuffled;
    for (const std::uint32_t i : order) {
        shuffled.push_back(world->entities[i]);
    }
    const BasicRegistry& registry = world->registry;
    const auto sum = [](const auto& keys, const auto& component) {
        double total = 0.0;
        for (const auto key : keys) {
            sum_step(total, component(key));
        }
        return total;
    };
    const auto by_index = [&](std::uint32_t i) -> const Position& { return world->arrays.position[i]; };
    const auto by_get = [&](Entity e) -> const Position& { return registry.get<Position>(e); };
    const auto by_try_get = [&](Entity e) -> const Position& { return *registry.try_get<Position>(e); };
    const char* const sums = "absolute difference of the sums in the same order";
    const std::string random = with_count("access 1 component, random entities", n);
    const double expected = sum(order, by_index);
    context.run(row(random, "plain array", n, sums), [&] { keep(sum(order, by_index)); });
    context.run(row(random, "get", n, sums, std::fabs(sum(shuffled, by_get) - expected)),
                [&] { keep(sum(shuffled, by_get)); });
    context.run(row(random, "try_get", n, sums, std::fabs(sum(shuffled, by_try_get) - expected)),
                [&] { keep(sum(shuffled, by_try_get)); });

    std::vector<std::uint32_t> in_order(n);
    std::iota(in_order.begin(), in_order.end(), 0U);
    const std::string ordered = with_count("access 1 component, entities in order", n);
    const double expected_in_order = sum(in_order, by_index);
    context.run(row(ordered, "plain array", n, sums), [&] { keep(sum(in_order, by_index)); });
    context.run(row(ordered, "get", n, sums, std::fabs(sum(world->entities, by_get) - expected_in_order)),
                [&] { keep(sum(world->entities, by_get)); });
    context.run(row(ordered, "try_get", n, sums, std::fabs(sum(world->entities, by_try_get) - expected_in_order)),
                [&] { keep(sum(world->entities, by_try_get)); });
}

void lifetime(const Context& context) {
    const std::size_t n = context.quick() ? 5'000 : 100'000;
    const std::string name = with_count("create with 3 components and destroy", n);
    const char* const metric = "entities left over, and handles still valid";
    const auto arrays = [&] {
        Arrays a;
        for (std::size_t i = 0; i < n; ++i) {
            a.position.push_back({1.0F, 2.0F, 3.0F});
            a.velocity.push_back({1.0F, 2.0F, 3.0F});
            a.energy.push_back({0.0F});
        }
        keep(a.position.data());
        while (!a.position.empty()) {
            a.position.pop_back();
            a.velocity.pop_back();
            a.energy.pop_back();
        }
        keep(a.position.data());
    };
    context.run(row(name, "plain arrays, push_back and pop_back", n, metric), arrays);

    BasicRegistry registry;
    std::vector<Entity> entities(n);
    const auto churn = [&] {
        for (Entity& e : entities) {
            e = registry.create();
            registry.emplace<Position>(e, 1.0F, 2.0F, 3.0F);
            registry.emplace<Velocity>(e, 1.0F, 2.0F, 3.0F);
            registry.emplace<Energy>(e, 0.0F);
        }
        for (const Entity e : entities) {
            registry.destroy(e);
        }
    };
    churn();
    double wrong = 0.0;
    registry.view<Position>().each([&](Entity, Position&) { wrong += 1.0; });
    for (const Entity e : entities) {
        wrong += registry.valid(e) ? 1.0 : 0.0;
    }
    context.run(row(name, "registry", n, metric, wrong), churn);
}

const Case one("ecs/iterate one component", iterate_one);
const Case three("ecs/iterate three components", [](const Context& context) { iterate_three(context, false); });
const Case three_shuffled("ecs/iterate three components, shuffled",
                          [](const Context& context) { iterate_three(context, true); });
const Case random_access("ecs/access", access);
const Case create_destroy("ecs/create and destroy", lifetime);

} // namespace
} // namespace alpenglow::bench
