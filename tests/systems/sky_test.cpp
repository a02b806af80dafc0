#include <registries.hpp>

#include <alpenglow/core/constants.hpp>
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
class SkySystems : public ::testing::Test {
protected:
    R registry;
    Frame frame;
    typename R::entity_type place = registry.create();

    void SetUp() override {
        registry.template emplace<CelestialState>(place).to_sun = towards(30.0);
        registry.template emplace<Atmosphere>(place);
    }
    typename R::entity_type receiver(int bands) {
        const auto entity = registry.create();
        registry.template emplace<SkyLightReceiver>(entity, SkyLightReceiver{bands, true});
        return entity;
    }
};
TYPED_TEST_SUITE(SkySystems, test::TestRegistries, test::RegistryNames);

TYPED_TEST(SkySystems, MakesTheSkyOnceAndKeepsIt) {
    EXPECT_EQ(update_sky(this->registry, this->frame).updated, 1U);
    const SystemReport again = update_sky(this->registry, this->frame);
    EXPECT_EQ(again.considered, 1U);
    EXPECT_EQ(again.updated, 0U);
    EXPECT_EQ(again.skipped, 1U);
    EXPECT_EQ(again.error_bound, 0.0);
    const SkyState& state = this->registry.template get<SkyState>(this->place);
    EXPECT_GT(state.sun_illuminance_lux.y, 1e4F);
    EXPECT_EQ(state.revision, 1U);
}

TYPED_TEST(SkySystems, RecomputesPastTheErrorOnly) {
    update_sky(this->registry, this->frame);
    auto& celestial = this->registry.template get<CelestialState>(this->place);
    celestial.to_sun = towards(30.01);
    const SystemReport small = update_sky(this->registry, this->frame);
    EXPECT_EQ(small.skipped, 1U);
    EXPECT_GT(small.error_bound, 0.0);
    EXPECT_LE(small.error_bound, 0.005);
    celestial.to_sun = towards(31.0);
    EXPECT_EQ(update_sky(this->registry, this->frame).updated, 1U);
    this->registry.template get<Atmosphere>(this->place).turbidity = 4.0F;
    EXPECT_EQ(update_sky(this->registry, this->frame).updated, 1U);
    EXPECT_EQ(this->registry.template get<SkyState>(this->place).revision, 3U);
}

TYPED_TEST(SkySystems, BadAirLeavesThePreviousSky) {
    update_sky(this->registry, this->frame);
    const SkyState before = this->registry.template get<SkyState>(this->place);
    this->registry.template get<Atmosphere>(this->place).turbidity = std::nanf("");
    const SystemReport report = update_sky(this->registry, this->frame);
    EXPECT_EQ(report.rejected, 1U);
    EXPECT_EQ(report.updated, 0U);
    const SkyState& after = this->registry.template get<SkyState>(this->place);
    EXPECT_EQ(after.revision, before.revision);
    EXPECT_EQ(after.turbidity, before.turbidity);
}

TYPED_TEST(SkySystems, NobodyLitNoSkyLight) {
    update_sky(this->registry, this->frame);
    const SystemReport nobody = update_sky_light(this->registry, this->frame);
    EXPECT_EQ(nobody.updated, 0U);
    EXPECT_EQ(nobody.skipped, 1U);
    EXPECT_EQ(this->registry.template try_get<SkyLightSh>(this->place), nullptr);
    const auto hidden = this->receiver(5);
    this->registry.template get<SkyLightReceiver>(hidden).visible = false;
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 0U);
}

TYPED_TEST(SkySystems, BandsFollowTheDemand) {
    update_sky(this->registry, this->frame);
    this->receiver(3);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 1U);
    EXPECT_EQ(this->registry.template get<SkyLightSh>(this->place).bands, 3);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 0U);
    const auto greedy = this->receiver(99);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 1U);
    EXPECT_EQ(this->registry.template get<SkyLightSh>(this->place).bands, 7);
    this->registry.destroy(greedy);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 0U); // more bands than asked for are no fault
    this->registry.template get<CelestialState>(this->place).to_sun = towards(50.0);
    update_sky(this->registry, this->frame);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 1U);
    EXPECT_EQ(this->registry.template get<SkyLightSh>(this->place).bands, 3);
    // Unused bands are zero.
    EXPECT_EQ(this->registry.template get<SkyLightSh>(this->place).coefficients[9], glm::vec3(0.0F));
    EXPECT_GT(this->registry.template get<SkyLightSh>(this->place).coefficients[0].y, 0.0F);
}

TYPED_TEST(SkySystems, TablesAreBuiltForReadersAndKept) {
    auto& air = this->registry.template get<Atmosphere>(this->place);
    air.model = SkyModel::scattering;
    // Nobody reads a table, and the fit has the SH: no table.
    this->receiver(3);
    const SystemReport none = update_sky(this->registry, this->frame);
    EXPECT_EQ(none.tables_rebuilt, 0U);
    EXPECT_EQ(this->registry.template get<SkyTables>(this->place).sun_view, nullptr);
    EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 1U);
    EXPECT_GT(this->registry.template get<SkyLightSh>(this->place).coefficients[0].z, 0.0F);
    const auto reader = this->registry.create();
    this->registry.template emplace<SkyTableReader>(reader);
    const SystemReport first = update_sky(this->registry, this->frame);
    EXPECT_EQ(first.tables_rebuilt, 2U); // the atmosphere and the view
    EXPECT_EQ(first.updated, 0U);        // the state stands
    const auto view = this->registry.template get<SkyTables>(this->place).sun_view;
    ASSERT_NE(view, nullptr);
    const SystemReport again = update_sky(this->registry, this->frame);
    EXPECT_EQ(again.tables_rebuilt, 0U);
    EXPECT_EQ(again.tables_kept, 2U);
    // The sun moves: the view alone.
    this->registry.template get<CelestialState>(this->place).to_sun = towards(33.0);
    EXPECT_EQ(update_sky(this->registry, this->frame).tables_rebuilt, 1U);
    EXPECT_NE(this->registry.template get<SkyTables>(this->place).sun_view, view);
    // A bad air keeps sky and tables.
    const auto before = this->registry.template get<SkyTables>(this->place).atmosphere;
    this->registry.template get<Atmosphere>(this->place).turbidity = std::nanf("");
    const SystemReport bad = update_sky(this->registry, this->frame);
    EXPECT_EQ(bad.rejected, 1U);
    EXPECT_EQ(bad.tables_rebuilt, 0U);
    EXPECT_EQ(this->registry.template get<SkyTables>(this->place).atmosphere, before);
    // Not seen, not built; another model drops them.
    this->registry.template get<Atmosphere>(this->place) = {};
    update_sky(this->registry, this->frame);
    EXPECT_EQ(this->registry.template get<SkyTables>(this->place).atmosphere, nullptr);
}

TYPED_TEST(SkySystems, AltitudeComesFromTheObserver) {
    auto& air = this->registry.template get<Atmosphere>(this->place);
    air.model = SkyModel::scattering;
    this->receiver(3);
    this->registry.template emplace<Observer>(this->place).height_m = 12000.0;
    // The fit knows sea level only: the SH ask for the view.
    EXPECT_EQ(update_sky(this->registry, this->frame).tables_rebuilt, 2U);
    update_sky_light(this->registry, this->frame);
    const float high = this->registry.template get<SkyLightSh>(this->place).coefficients[0].z;
    const float sun = this->registry.template get<SkyState>(this->place).sun_illuminance_lux.z;
    this->registry.template get<Observer>(this->place).height_m = 0.0;
    EXPECT_EQ(update_sky(this->registry, this->frame).updated, 1U);
    update_sky_light(this->registry, this->frame);
    EXPECT_LT(high, 0.5F * this->registry.template get<SkyLightSh>(this->place).coefficients[0].z);
    EXPECT_GT(sun, 1.1F * this->registry.template get<SkyState>(this->place).sun_illuminance_lux.z);
    this->registry.template get<Observer>(this->place).height_m = 1e6;
    EXPECT_EQ(update_sky(this->registry, this->frame).rejected, 1U);
}

TYPED_TEST(SkySystems, EveryModelMakesALightAndASky) {
    this->receiver(5);
    for (const SkyModel model : {SkyModel::preetham, SkyModel::perez, SkyModel::cie_clear, SkyModel::cie_overcast,
                                 SkyModel::asrc_cie, SkyModel::cie_general, SkyModel::scattering}) {
        this->registry.template get<Atmosphere>(this->place).model = model;
        EXPECT_EQ(update_sky(this->registry, this->frame).updated, 1U);
        EXPECT_EQ(update_sky_light(this->registry, this->frame).updated, 1U);
        // Daylight at 30 degrees: 5 to 60 klux from the sky.
        const float c = this->registry.template get<SkyLightSh>(this->place).coefficients[0].y;
        EXPECT_GT(c, 2e3F) << int(model);
        EXPECT_LT(c, 6e4F) << int(model);
    }
}

TYPED_TEST(SkySystems, AnEmptySceneDoesNothing) {
    TypeParam empty;
    EXPECT_EQ(update_sky(empty, this->frame).considered, 0U);
    EXPECT_EQ(update_sky_light(empty, this->frame).considered, 0U);
}

} // namespace
} // namespace alpenglow
