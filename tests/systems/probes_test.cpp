#include <registries.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/systems/probes.hpp>
#include <alpenglow/systems/sky.hpp>
#include <alpenglow/systems/sky_light.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace alpenglow {
namespace {

glm::vec3 towards(double altitude_deg) {
    const double a = altitude_deg * degree_rad;
    return glm::vec3(glm::dvec3(std::cos(a), 0.0, std::sin(a)));
}

template <class R>
class ProbeSystems : public ::testing::Test {
protected:
    using Entity = typename R::entity_type;
    R registry;
    Frame frame;
    Entity sky = registry.create();

    void SetUp() override {
        registry.template emplace<CelestialState>(sky).to_sun = towards(30.0);
        registry.template emplace<Atmosphere>(sky);
    }
    Entity grid(const glm::vec3& min_m, const glm::vec3& max_m, int count = 5) {
        const Entity entity = registry.create();
        ProbeGrid& made = registry.template emplace<ProbeGrid>(entity);
        made.min_m = min_m;
        made.max_m = max_m;
        made.count = glm::ivec3(count);
        return entity;
    }
    Entity receiver(const glm::vec3& position_m) {
        const Entity entity = registry.create();
        registry.template emplace<ProbeReceiver>(entity, ProbeReceiver{position_m, true});
        return entity;
    }
    // A frame of all systems; returns what the probes did.
    SystemReport step() {
        update_sky(registry, frame);
        update_sky_light(registry, frame);
        SystemReport report = update_probes(registry, frame);
        receivers = update_probe_receivers(registry, frame);
        return report;
    }
    const ReceiverSh& light(Entity entity) { return registry.template get<ReceiverSh>(entity); }

    SystemReport receivers;
};
TYPED_TEST_SUITE(ProbeSystems, test::TestRegistries, test::RegistryNames);

TYPED_TEST(ProbeSystems, NobodyLitNoWorkNotEvenTheSkys) {
    this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    for (int i = 0; i < 3; ++i) {
        const SystemReport report = this->step();
        EXPECT_EQ(report.considered, 125U);
        EXPECT_EQ(report.updated, 0U);
        EXPECT_EQ(report.skipped, 125U);
    }
    EXPECT_EQ(this->registry.template try_get<SkyLightSh>(this->sky), nullptr);
}

TYPED_TEST(ProbeSystems, LightsAReceiverAndThenRests) {
    this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    const auto hut = this->receiver(glm::vec3(4.0F));
    EXPECT_EQ(this->step().updated, 8U); // asks for the sky
    EXPECT_EQ(this->step().updated, 8U); // has it
    const SystemReport rest = this->step();
    EXPECT_EQ(rest.updated, 0U);
    EXPECT_EQ(rest.skipped, 125U);
    EXPECT_EQ(this->receivers.skipped, 1U);
    const ReceiverSh& light = this->light(hut);
    EXPECT_EQ(light.source, ReceiverSh::Source::grid);
    EXPECT_EQ(light.order, 3);
    // The mean radiance holds sky and sun: some 1e4 cd/m^2 on a clear day.
    EXPECT_GT(light.coefficients[0].y, 1e4F);
    EXPECT_LT(light.coefficients[0].y, 1e5F);
    EXPECT_EQ(this->registry.template get<SkyLightSh>(this->sky).bands, 3);
}

TYPED_TEST(ProbeSystems, HiddenReceiversWantNothing) {
    this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    const auto hut = this->receiver(glm::vec3(4.0F));
    this->registry.template get<ProbeReceiver>(hut).visible = false;
    EXPECT_EQ(this->step().updated, 0U);
    EXPECT_EQ(this->receivers.updated, 0U);
    this->registry.template get<ProbeReceiver>(hut).visible = true;
    EXPECT_EQ(this->step().updated, 8U);
    EXPECT_EQ(this->receivers.updated, 1U);
}

TYPED_TEST(ProbeSystems, FollowsTheSunPastTheErrorOnly) {
    const auto entity = this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    this->registry.template get<ProbeGrid>(entity).max_error = 0.05F;
    this->receiver(glm::vec3(4.0F));
    this->step();
    this->step();
    auto& celestial = this->registry.template get<CelestialState>(this->sky);
    celestial.to_sun = towards(30.2);
    const SystemReport small = this->step();
    EXPECT_EQ(small.updated, 0U);
    EXPECT_GT(small.error_bound, 0.0);
    EXPECT_LE(small.error_bound, 0.05);
    celestial.to_sun = towards(40.0);
    EXPECT_EQ(this->step().updated, 8U);
    EXPECT_EQ(this->receivers.updated, 1U);
}

TYPED_TEST(ProbeSystems, ABudgetIsKeptAndConvergesInTheStatedFrames) {
    const auto entity = this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    this->registry.template get<ProbeGrid>(entity).budget = 20;
    for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                this->receiver(2.5F * glm::vec3(x, y, z) + 1.0F);
            }
        }
    }
    this->step(); // the sky is asked for
    std::uint32_t frames = 0;
    for (std::uint32_t updated = 1; updated > 0; ++frames) {
        updated = this->step().updated;
        EXPECT_LE(updated, 20U);
        ASSERT_LT(frames, 50U);
    }
    // 20 were made under no sky; then 125 in ceil(125 / 20) frames, and one that finds nothing to do.
    EXPECT_LE(frames, 8U);
}

TYPED_TEST(ProbeSystems, TheFinestGridThenTheNearestProbeThenTheEnvironment) {
    this->grid(glm::vec3(-50.0F), glm::vec3(50.0F));
    this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    const auto far = this->registry.create();
    auto& probe = this->registry.template emplace<LightProbe>(far);
    probe.position_m = {100.0F, 0.0F, 0.0F};
    probe.radius_m = 20.0F;
    const auto inside = this->receiver(glm::vec3(5.0F));
    const auto outside = this->receiver(glm::vec3(-20.0F));
    const auto beyond = this->receiver({110.0F, 0.0F, 0.0F});
    const auto nowhere = this->receiver({500.0F, 0.0F, 0.0F});
    this->step();
    this->step();
    EXPECT_EQ(this->light(inside).source, ReceiverSh::Source::grid);
    EXPECT_EQ(this->light(outside).source, ReceiverSh::Source::grid);
    EXPECT_NE(this->light(inside).source_id, this->light(outside).source_id);
    EXPECT_EQ(this->light(beyond).source, ReceiverSh::Source::probe);
    EXPECT_EQ(this->light(nowhere).source, ReceiverSh::Source::none);
    // Under one sky, in the open, light is the same everywhere.
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_LE(glm::distance(this->light(inside).coefficients[i], this->light(beyond).coefficients[i]),
                  1e-4F * this->light(inside).coefficients[0].y);
    }
    EnvironmentMap map;
    map.width = 4;
    map.height = 2;
    map.radiance.assign(8, glm::vec3(100.0F));
    this->registry.template emplace<EnvironmentMap>(this->registry.create(), map);
    this->step();
    EXPECT_EQ(this->light(nowhere).source, ReceiverSh::Source::environment);
    EXPECT_NEAR(this->light(nowhere).coefficients[0].x, 100.0 * std::sqrt(4.0 * pi), 0.1);
    EXPECT_NEAR(this->light(inside).coefficients[0].x, 100.0 * std::sqrt(4.0 * pi), 0.1); // it took the sky's place
}

TYPED_TEST(ProbeSystems, MovingReceiversAreBlendedAgainStandingOnesNot) {
    this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    this->receiver(glm::vec3(2.0F));
    const auto walker = this->receiver(glm::vec3(7.0F));
    this->step();
    this->step();
    this->step();
    EXPECT_EQ(this->receivers.updated, 0U);
    this->registry.template get<ProbeReceiver>(walker).position_m.x += 0.2F; // stays in its cell
    this->step();
    EXPECT_EQ(this->receivers.updated, 1U);
    EXPECT_EQ(this->receivers.skipped, 1U);
}

TYPED_TEST(ProbeSystems, RefusesWhatIsBadAndKeepsWhatWasGood) {
    const auto entity = this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    const auto hut = this->receiver(glm::vec3(4.0F));
    this->step();
    this->step();
    const ReceiverSh before = this->light(hut);
    auto& grid = this->registry.template get<ProbeGrid>(entity);
    std::swap(grid.min_m, grid.max_m);
    const auto probe = this->registry.create();
    this->registry.template emplace<LightProbe>(probe).order = 9;
    EXPECT_EQ(this->step().rejected, 2U);
    std::swap(grid.min_m, grid.max_m);
    EXPECT_EQ(this->step().rejected, 1U);
    EXPECT_EQ(this->light(hut).coefficients, before.coefficients);
    // A sky that is not a number: everything stands.
    this->registry.template get<SkyState>(this->sky).sun_illuminance_lux.x = std::nanf("");
    EXPECT_GE(update_probes(this->registry, this->frame).rejected, 1U);
}

TYPED_TEST(ProbeSystems, CapturesWithTheGamesRenderer) {
    const auto entity = this->grid(glm::vec3(0.0F), glm::vec3(10.0F));
    this->registry.template get<ProbeGrid>(entity).source = ProbeSource::captured;
    const auto hut = this->receiver(glm::vec3(4.0F));
    int faces = 0;
    probes::Capture capture;
    capture.budget = 4;
    capture.render = [&](const glm::vec3&, int, int, std::span<glm::vec3> texels) {
        ++faces;
        std::fill(texels.begin(), texels.end(), glm::vec3(50.0F));
    };
    EXPECT_EQ(update_probes(this->registry, this->frame, capture).updated, 4U);
    EXPECT_EQ(update_probes(this->registry, this->frame, capture).updated, 4U);
    EXPECT_EQ(update_probes(this->registry, this->frame, capture).updated, 0U);
    EXPECT_EQ(faces, 48);
    update_probe_receivers(this->registry, this->frame);
    EXPECT_NEAR(this->light(hut).coefficients[0].y, 50.0 * std::sqrt(4.0 * pi), 1e-2);
}

TYPED_TEST(ProbeSystems, AnEmptySceneDoesNothing) {
    TypeParam empty;
    EXPECT_EQ(update_probes(empty, this->frame).considered, 0U);
    EXPECT_EQ(update_probe_receivers(empty, this->frame).considered, 0U);
}

// A place below clouds gets the light of their cover, as if the sky itself were that; one without a cover keeps the
// clear sky's; and the light below follows the clear sky's brightness.
TYPED_TEST(ProbeSystems, BelowCloudsTheCoversLightTakesTheSkys) {
    const auto probe = [&](float x) {
        const auto entity = this->registry.create();
        LightProbe& made = this->registry.template emplace<LightProbe>(entity);
        made.position_m = {x, 0.0F, 0.0F};
        made.radius_m = 10.0F;
        made.deringing = Deringing::none;
        made.ground_albedo = glm::vec3(0.0F);
        this->receiver(made.position_m);
        return entity;
    };
    const auto below = probe(0.0F);
    const auto away = probe(100.0F);
    this->step();
    this->step();
    const SkyLightSh clear = this->registry.template get<SkyLightSh>(this->sky);
    const auto light = [&](auto entity) { return this->registry.template get<LightProbeSh>(entity).coefficients; };
    const auto before = light(below);
    ASSERT_EQ(before[0], light(away)[0]);

    CloudCoverLight& cover = this->registry.template emplace<CloudCoverLight>(below);
    for (std::size_t k = 0; k < cover.sky.size(); ++k) {
        cover.sky[k] = glm::vec3(0.1F + 0.01F * static_cast<float>(k));
    }
    cover.clear = 0.5F * clear.coefficients[0]; // the sky has become twice as bright since
    cover.sun = 0.0F;
    this->step();
    EXPECT_EQ(light(below), before) << "a cover that was never made";
    cover.revision = 1;
    EXPECT_GE(this->step().updated, 1U);
    for (std::size_t k = 0; k < 9; ++k) {
        EXPECT_NEAR(light(below)[k].g, 2.0F * cover.sky[k].g, 1e-4F) << k; // no sun, no ground: the cover's sky alone
    }
    EXPECT_EQ(light(away), before);
    EXPECT_EQ(this->step().updated, 0U);
}

} // namespace
} // namespace alpenglow
