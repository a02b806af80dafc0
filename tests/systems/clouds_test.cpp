#include <registries.hpp>

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/systems/clouds.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace alpenglow {
namespace {

glm::vec3 sun_at(float elevation) {
    return {std::cos(elevation), 0.0F, std::sin(elevation)};
}

template <class R>
class CloudSystem : public ::testing::Test {
protected:
    R registry;
    Frame frame;
    std::shared_ptr<const clouds::BrickVolume> volume =
        std::make_shared<clouds::BrickVolume>(clouds::noise_cloud(71, 24));

    auto sky(const glm::vec3& to_sun) {
        const auto entity = registry.create();
        SkyState state;
        state.to_sun = to_sun;
        state.sun_illuminance_lux = glm::vec3(100000.0F, 95000.0F, 90000.0F);
        state.to_moon = {0.0F, 0.6F, 0.8F};
        state.moon_illuminance_lux = glm::vec3(0.2F);
        registry.template emplace<SkyState>(entity, state);
        SkyLightSh sh;
        sh.bands = 4;
        sh.coefficients[0] = glm::vec3(9000.0F, 12000.0F, 18000.0F);
        sh.coefficients[2] = glm::vec3(1000.0F, 2000.0F, 3000.0F);
        registry.template emplace<SkyLightSh>(entity, sh);
        return entity;
    }

    auto cloud() {
        const auto entity = registry.create();
        CloudVolume c;
        c.volume = volume;
        c.extinction_per_m = 0.5F;
        registry.template emplace<CloudVolume>(entity, c);
        return entity;
    }

    // Until nothing is queued.
    int settle() {
        int frames = 0;
        while (update_clouds(registry, frame).updated > 0 && frames < 100) {
            ++frames;
        }
        return frames;
    }

    // Looking nearly into the sun, where its direction matters most.
    clouds::Picture against_the_sun(const clouds::CloudLighting& lighting, const glm::vec3& to_sun) const {
        return clouds::march(*volume, lighting,
                             clouds::look_at(glm::dvec3(12.0) - glm::dvec3(to_sun) * 50.0 + glm::dvec3(0.0, 3.0, 2.0),
                                             {12.0, 12.0, 12.0}, 0.35F, 24, 18));
    }

    clouds::Picture picture(const clouds::CloudLighting& lighting) const {
        return clouds::march(*volume, lighting,
                             clouds::look_at({-40.0, -20.0, 30.0}, {12.0, 12.0, 12.0}, 0.35F, 24, 18));
    }
};

double relative_difference(const clouds::Picture& a, const clouds::Picture& b) {
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        error += std::pow(double(a.radiance[i].y - b.radiance[i].y), 2.0);
        norm += std::pow(double(b.radiance[i].y), 2.0);
    }
    return std::sqrt(error / norm);
}

TYPED_TEST_SUITE(CloudSystem, test::TestRegistries, test::RegistryNames);

TYPED_TEST(CloudSystem, AStaticSceneIsNoWorkAfterItsFirstFrames) {
    this->sky(sun_at(0.6F));
    const auto entity = this->cloud();
    const int frames = this->settle();
    EXPECT_GT(frames, 1); // the budget spread it
    EXPECT_LT(frames, 40);
    const CloudLight before = this->registry.template get<CloudLight>(entity);
    EXPECT_TRUE(before.lighting != nullptr);
    EXPECT_EQ(before.lights, 1); // the moon is a millionth of the sun
    EXPECT_EQ(before.volume_revision, 1U);
    for (int i = 0; i < 5; ++i) {
        const SystemReport report = update_clouds(this->registry, this->frame);
        EXPECT_EQ(report.considered, 1U);
        EXPECT_EQ(report.updated, 0U);
        EXPECT_EQ(report.skipped, 1U);
        EXPECT_EQ(report.error_bound, 0.0);
    }
    EXPECT_EQ(this->registry.template get<CloudLight>(entity).revision, before.revision);
    EXPECT_EQ(this->registry.template get<CloudLight>(entity).volume_revision, 1U);
    EXPECT_EQ(this->registry.template get<SkyLightReceiver>(entity).bands, 4);
    // Wind moves the cloud; its light stays.
    this->registry.template get<CloudVolume>(entity).offset_m.x += 100.0;
    EXPECT_EQ(update_clouds(this->registry, this->frame).updated, 0U);
}

TYPED_TEST(CloudSystem, NothingToDoForCloudsThatNobodySees) {
    this->sky(sun_at(0.6F));
    const auto hidden = this->cloud();
    this->registry.template get<CloudVolume>(hidden).visible = false;
    const auto tiny = this->cloud();
    this->registry.template get<CloudVolume>(tiny).size_px = 0.5F;
    const auto none = this->cloud();
    this->registry.template get<CloudVolume>(none).volume = nullptr;
    const SystemReport report = update_clouds(this->registry, this->frame);
    EXPECT_EQ(report.skipped, 3U);
    EXPECT_EQ(report.updated, 0U);
    EXPECT_FALSE(this->registry.template get<SkyLightReceiver>(hidden).visible);
}

TYPED_TEST(CloudSystem, BadValuesAreRejectedAndTheLastLightStands) {
    this->sky(sun_at(0.6F));
    const auto entity = this->cloud();
    this->settle();
    const auto lighting = this->registry.template get<CloudLight>(entity).lighting;
    const float bad[] = {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    for (const float value : bad) {
        this->registry.template get<CloudVolume>(entity).extinction_per_m = value;
        const SystemReport report = update_clouds(this->registry, this->frame);
        EXPECT_EQ(report.rejected, 1U);
        EXPECT_EQ(report.updated, 0U);
        EXPECT_EQ(this->registry.template get<CloudLight>(entity).lighting, lighting);
    }
    this->registry.template get<CloudVolume>(entity).extinction_per_m = 0.5F;
    this->registry.template get<CloudVolume>(entity).anisotropy = 1.0F;
    EXPECT_EQ(update_clouds(this->registry, this->frame).rejected, 1U);
    const auto message = clouds::check(this->registry.template get<CloudVolume>(entity)).error().message();
    EXPECT_NE(message.find("CloudVolume::anisotropy"), std::string::npos);
}

TYPED_TEST(CloudSystem, ATurningSunStaysWithinTheBudgetOfError) {
    const auto sky = this->sky(sun_at(0.6F));
    const auto entity = this->cloud();
    auto& cloud = this->registry.template get<CloudVolume>(entity);
    cloud.max_error = 0.04F;
    cloud.skylit = false;
    this->settle();
    int refreshed = 0;
    for (int step = 1; step <= 60; ++step) {
        auto& state = this->registry.template get<SkyState>(sky);
        state.to_sun = sun_at(0.6F + 0.0006F * static_cast<float>(step));
        refreshed += update_clouds(this->registry, this->frame).updated > 0 ? 1 : 0;
        if (step % 12 != 0) {
            continue;
        }
        // In secret: what it should be. Moments lag the sun by a few frames of slices; that error has its own
        // allowance.
        const CloudLight& light = this->registry.template get<CloudLight>(entity);
        clouds::CloudLighting exact;
        exact.reset(*this->volume, light.lighting->medium(), light.lighting->settings());
        exact.bake_light(0, {state.to_sun, state.sun_illuminance_lux, 0.0F});
        EXPECT_LT(relative_difference(this->picture(*light.lighting), this->picture(exact)),
                  double(light.error_bound) + 0.01)
            << step;
        EXPECT_LT(relative_difference(this->against_the_sun(*light.lighting, state.to_sun),
                                      this->against_the_sun(exact, state.to_sun)),
                  double(light.error_bound) + 0.01)
            << step;
        EXPECT_LE(light.error_bound, 0.04F);
    }
    EXPECT_LT(refreshed, 60);
    EXPECT_GT(refreshed, 1);
}

TYPED_TEST(CloudSystem, ColoursFollowWithoutABake) {
    const auto sky = this->sky(sun_at(0.6F));
    const auto entity = this->cloud();
    this->registry.template get<CloudVolume>(entity).skylit = false;
    this->settle();
    const clouds::Picture before = this->picture(*this->registry.template get<CloudLight>(entity).lighting);
    this->registry.template get<SkyState>(sky).sun_illuminance_lux *= 0.5F;
    EXPECT_EQ(update_clouds(this->registry, this->frame).updated, 0U);
    const clouds::Picture after = this->picture(*this->registry.template get<CloudLight>(entity).lighting);
    for (std::size_t i = 0; i < before.radiance.size(); ++i) {
        EXPECT_NEAR(after.radiance[i].x, 0.5F * before.radiance[i].x, 1e-3F * before.radiance[i].x);
    }
}

TYPED_TEST(CloudSystem, WhatOtherCloudsLeaveOfTheSunFollowsWithoutABake) {
    this->sky(sun_at(0.6F));
    const auto below = this->cloud();
    const auto above = this->cloud();
    this->settle();
    const auto sun = [&](auto entity) {
        return this->registry.template get<CloudLight>(entity).lighting->lights()[0].irradiance;
    };
    const glm::vec3 whole = sun(above);
    EXPECT_EQ(sun(below), whole);
    this->registry.template get<CloudVolume>(below).sun_share = 0.25F;
    EXPECT_EQ(update_clouds(this->registry, this->frame).updated, 0U);
    EXPECT_EQ(sun(below), 0.25F * whole);
    EXPECT_EQ(sun(above), whole);
}

TYPED_TEST(CloudSystem, TheMoonTakesOverWhenTheSunHasSet) {
    const auto sky = this->sky(sun_at(0.6F));
    const auto entity = this->cloud();
    this->settle();
    EXPECT_EQ(this->registry.template get<CloudLight>(entity).kind[0], 1);
    this->registry.template get<SkyState>(sky).to_sun = sun_at(-0.3F);
    this->settle();
    EXPECT_EQ(this->registry.template get<CloudLight>(entity).kind[0], 2);
    this->registry.template get<SkyState>(sky).to_moon = {0.0F, 0.8F, -0.6F};
    this->settle();
    EXPECT_EQ(this->registry.template get<CloudLight>(entity).lights, 0);
}

TYPED_TEST(CloudSystem, ManyCloudsShareTheBudgetAndAllGetTheirLight) {
    this->sky(sun_at(0.8F));
    this->volume = std::make_shared<clouds::BrickVolume>(clouds::noise_cloud(72, 8));
    this->registry.ctx().template emplace<CloudBudget>(CloudBudget{60, 2});
    std::vector<decltype(this->cloud())> all;
    for (int i = 0; i < 200; ++i) {
        all.push_back(this->cloud());
    }
    const SystemReport first = update_clouds(this->registry, this->frame);
    EXPECT_EQ(first.considered, 200U);
    EXPECT_LE(first.updated, 10U);
    int frames = 0;
    while (update_clouds(this->registry, this->frame).updated > 0 && frames < 2000) {
        ++frames;
    }
    for (const auto entity : all) {
        const CloudLight& light = this->registry.template get<CloudLight>(entity);
        ASSERT_TRUE(light.lighting != nullptr);
        EXPECT_EQ(light.error_bound, 0.0F);
        EXPECT_FALSE(light.lighting->working());
    }
}

} // namespace
} // namespace alpenglow
