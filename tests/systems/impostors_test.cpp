#include <alpenglow/systems/impostors.hpp>

#include "registries.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace alpenglow {
namespace {

template <class R>
class ImpostorsSystem : public ::testing::Test {
protected:
    R registry;
    Frame frame{0, 1.0 / 60.0};

    auto add_camera() {
        const auto e = registry.create();
        registry.template emplace<ImpostorView>(e, ImpostorView{.tan_left = -0.9,
                                                                .tan_right = 0.9,
                                                                .tan_bottom = -0.5,
                                                                .tan_top = 0.5,
                                                                .width_px = 960,
                                                                .height_px = 540});
        return e;
    }
    auto add(const glm::dvec3& centre_m) {
        const auto e = registry.create();
        registry.template emplace<Impostor>(e, Impostor{.centre_m = centre_m, .radius_m = 100.0});
        return e;
    }
};
TYPED_TEST_SUITE(ImpostorsSystem, test::TestRegistries, test::RegistryNames);

TYPED_TEST(ImpostorsSystem, NoCameraNoWork) {
    this->add({0, 2000, 0});
    const SystemReport report = update_impostors(this->registry, this->frame);
    EXPECT_STREQ(report.system, "impostors");
    EXPECT_EQ(report.considered, 0U);
    EXPECT_EQ(report.updated, 0U);
}

TYPED_TEST(ImpostorsSystem, OneCaptureThenNone) {
    const auto camera = this->add_camera();
    const auto cloud = this->add({0, 2000, 0});
    const auto behind = this->add({0, -2000, 0});
    SystemReport report = update_impostors(this->registry, this->frame);
    EXPECT_EQ(report.considered, 2U);
    EXPECT_EQ(report.updated, 1U);
    EXPECT_EQ(this->registry.template get<ImpostorState>(cloud).captures, 1U);
    EXPECT_EQ(this->registry.template get<ImpostorState>(behind).captures, 0U);
    for (int k = 0; k < 50; ++k) {
        report = update_impostors(this->registry, this->frame);
        ASSERT_EQ(report.updated, 0U);
        ASSERT_EQ(report.skipped, 2U);
        ASSERT_EQ(report.error_bound, 0.0);
    }
    // A little motion is within the tolerance, more is not.
    this->registry.template get<ImpostorView>(camera).eye_m.x += 0.5;
    report = update_impostors(this->registry, this->frame);
    EXPECT_EQ(report.updated, 0U);
    EXPECT_GT(report.error_bound, 0.0);
    EXPECT_LE(report.error_bound, 1.0);
    EXPECT_EQ(this->registry.template get<ImpostorState>(cloud).error, report.error_bound);
    this->registry.template get<ImpostorView>(camera).eye_m.x += 800.0;
    EXPECT_EQ(update_impostors(this->registry, this->frame).updated, 1U);
    // Its content has changed.
    for (int k = 0; k < 30; ++k) {
        update_impostors(this->registry, this->frame);
    }
    this->registry.template get<Impostor>(cloud).content += 0.5;
    EXPECT_EQ(update_impostors(this->registry, this->frame).updated, 1U);
    // Inside, the view itself is drawn.
    this->registry.template get<ImpostorView>(camera).eye_m = {0, 1990, 0};
    EXPECT_EQ(update_impostors(this->registry, this->frame).updated, 1U);
    EXPECT_TRUE(this->registry.template get<ImpostorState>(cloud).inside);
}

TYPED_TEST(ImpostorsSystem, LightColourIsFreeAndDirectionIsNot) {
    this->add_camera();
    this->add({0, 2000, 0});
    const auto light = this->registry.create();
    this->registry.template emplace<ImpostorLight>(light);
    update_impostors(this->registry, this->frame);
    this->registry.template get<ImpostorLight>(light).key_lux = glm::vec3(50.0F, 20.0F, 5.0F);
    EXPECT_EQ(update_impostors(this->registry, this->frame).updated, 0U);
    this->registry.template get<ImpostorLight>(light).to_key = glm::vec3(0.6F, 0.0F, 0.8F);
    EXPECT_EQ(update_impostors(this->registry, this->frame).updated, 1U);
}

TYPED_TEST(ImpostorsSystem, BadInputIsRejected) {
    this->add_camera();
    const auto cloud = this->add({0, 2000, 0});
    this->registry.template get<Impostor>(cloud).radius_m = std::numeric_limits<double>::quiet_NaN();
    const SystemReport report = update_impostors(this->registry, this->frame);
    EXPECT_EQ(report.rejected, 1U);
    EXPECT_EQ(report.updated, 0U);
}

TYPED_TEST(ImpostorsSystem, DestroyedEntitiesGiveUpTheirPictures) {
    this->add_camera();
    const auto cloud = this->add({0, 2000, 0});
    update_impostors(this->registry, this->frame);
    auto& f = this->registry.ctx().template get<ImpostorFrame>();
    EXPECT_EQ(f.scheduler.pictures(), 1U);
    this->registry.destroy(cloud);
    update_impostors(this->registry, this->frame);
    EXPECT_EQ(f.scheduler.pictures(), 0U);
    EXPECT_EQ(f.plan.released.size(), 1U);
}

} // namespace
} // namespace alpenglow
