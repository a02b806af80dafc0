#include <sandbox/scene/scene.hpp>

#include <alpenglow/ephemeris/time.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace alpenglow::sandbox {
namespace {

const std::string good = R"({
    "name": "test",
    "time_utc": "2026-06-21T05:30:00Z",
    "observer": {"latitude_deg": 47.27, "longitude_deg": 11.39}
})";

// `good` with one more member, or with a part replaced.
std::string with(const std::string& member) {
    return good.substr(0, good.size() - 2) + ",\n" + member + "}";
}
std::string replaced(std::string from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
}

void expect_error(const std::string& text, const std::string& field, const std::string& value,
                  const std::string& expected) {
    const Result<Scene> scene = parse_scene(text, "x.json");
    ASSERT_FALSE(scene) << text;
    const std::string message = scene.error().message();
    EXPECT_NE(message.find("x.json"), std::string::npos) << message;
    EXPECT_NE(message.find(field), std::string::npos) << message;
    EXPECT_NE(message.find(value), std::string::npos) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
}

TEST(Scene, ReadsEveryField) {
    const Result<Scene> scene = parse_scene(R"({
        "name": "n", "description": "d", "time_utc": "2026-12-21T23:59:59+01:00", "time_rate": 60,
        "observer": {"latitude_deg": -33.5, "longitude_deg": 151, "height_m": 20},
        "atmosphere": {"turbidity": 3, "ozone_atm_cm": 0.3, "ground_albedo": [0.1, 0.2, 0.3]},
        "camera": {"position_m": [1, 2, 3], "yaw_deg": 90, "pitch_deg": -5, "fov_deg": 45},
        "exposure": {"bias_ev": -1.5}, "quality": "full", "probes": {"deringing": "paper", "show": false},
        "chart": {"show": "sky", "bands": 7, "filter": "sinc"}})",
                                            "x.json");
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->name, "n");
    EXPECT_EQ(scene->description, "d");
    EXPECT_EQ(scene->utc_j2000_s, *ephemeris::parse_time("2026-12-21T22:59:59Z"));
    EXPECT_EQ(scene->time_rate, 60.0);
    EXPECT_EQ(scene->latitude_deg, -33.5);
    EXPECT_EQ(scene->longitude_deg, 151.0);
    EXPECT_EQ(scene->height_m, 20.0);
    EXPECT_EQ(scene->atmosphere.turbidity, 3.0F);
    EXPECT_EQ(scene->atmosphere.ozone_atm_cm, 0.3F);
    EXPECT_EQ(scene->atmosphere.ground_albedo, glm::vec3(0.1F, 0.2F, 0.3F));
    EXPECT_EQ(scene->camera_position_m, glm::vec3(1.0F, 2.0F, 3.0F));
    EXPECT_EQ(scene->exposure_bias_ev, -1.5F);
    EXPECT_EQ(scene->quality, Quality::full);
    EXPECT_EQ(scene->chart.show, Chart::sky);
    EXPECT_EQ(scene->chart.bands, 7);
    EXPECT_EQ(scene->chart.filter, ChartFilter::sinc);
    ASSERT_TRUE(scene->probes);
    EXPECT_EQ(scene->probes->deringing, Deringing::paper);
    EXPECT_FALSE(scene->probes->show);
    const Camera camera = scene_camera(*scene);
    EXPECT_NEAR(camera.forward().x, std::cos(5.0 * 3.14159265 / 180.0), 1e-6);
    EXPECT_NEAR(camera.fov_y_rad, 0.785398, 1e-5);
}

TEST(Scene, ReadsEverySkyModel) {
    for (std::size_t model = 0; model < sky_model_names.size(); ++model) {
        const Result<Scene> scene =
            parse_scene(with("\"atmosphere\": {\"model\": \"" + std::string(sky_model_names[model]) + "\"}"), "x.json");
        ASSERT_TRUE(scene) << scene.error().message();
        EXPECT_EQ(scene->atmosphere.model, static_cast<SkyModel>(model));
    }
    const Result<Scene> perez = parse_scene(
        with(R"("atmosphere": {"model": "perez", "clearness": 1.5, "brightness": 0.3, "zenith_cd_m2": 4000})"),
        "x.json");
    ASSERT_TRUE(perez) << perez.error().message();
    EXPECT_EQ(perez->atmosphere.clearness, 1.5F);
    EXPECT_EQ(perez->atmosphere.brightness, 0.3F);
    EXPECT_EQ(perez->atmosphere.zenith_cd_m2, 4000.0F);
}

TEST(Scene, TheScenesAreThereAndRight) {
    const std::vector<std::string> names = builtin_scene_names();
    ASSERT_GE(names.size(), 8U);
    EXPECT_EQ(names.front(), default_scene);
    for (const std::string& name : names) {
        const Result<Scene> scene = load_scene(name);
        ASSERT_TRUE(scene) << scene.error().message();
        EXPECT_EQ(scene->name, name);
        EXPECT_FALSE(scene->description.empty());
    }
    const Result<Scene> first = load_scene("alpine-morning");
    EXPECT_EQ(first->time_utc, "2026-06-21T05:30:00Z");
    EXPECT_EQ(first->latitude_deg, 47.27);
    EXPECT_EQ(first->longitude_deg, 11.39);
    EXPECT_LT(load_scene("southern-summer")->latitude_deg, 0.0);
    EXPECT_GT(load_scene("polar-summer")->latitude_deg, 66.6);
}

TEST(Scene, HasNoProbesUnlessItAsksForThem) {
    EXPECT_FALSE(parse_scene(good, "x.json")->probes);
    const Result<Scene> scene = parse_scene(with(R"("probes": {})"), "x.json");
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_TRUE(scene->probes);
    EXPECT_EQ(scene->probes->deringing, Deringing::exact);
    EXPECT_TRUE(scene->probes->show);
}

TEST(Scene, ErrorsNameFileFieldValueAndWhatWouldBeRight) {
    expect_error(with(R"("probes": {"source": "painted"})"), "probes.source", "painted", "assembled or captured");
    expect_error(with(R"("environment": {"scale": 2})"), "environment.file", "is missing", "must be given");
    expect_error(with(R"("environment": {"file": "a.hdr", "scale": 0})"), "environment.scale", "0", "a number from");
    expect_error(with(R"("probes": {"deringing": "hann"})"), "probes.deringing", "hann", "none, paper or exact");
    expect_error(with(R"("probes": {"deringing": 3})"), "probes.deringing", "3", "none, paper or exact");
    expect_error(with(R"("probes": {"show": 1})"), "probes.show", "1", "true or false");
    expect_error(with(R"("probes": {"grid": 1})"), "probes.grid", "unknown field", "one of deringing, source, show");
    expect_error(with(R"("probes": true)"), "probes", "true", "an object");
    expect_error(replaced("47.27", "91"), "observer.latitude_deg", "91", "-90");
    expect_error(replaced("11.39", "-180.5"), "observer.longitude_deg", "-180.5", "180");
    expect_error(replaced("47.27", "\"north\""), "observer.latitude_deg", "north", "a number");
    expect_error(replaced("47.27", "null"), "observer.latitude_deg", "null", "a number");
    expect_error(replaced("47.27", "true"), "observer.latitude_deg", "true", "a number");
    expect_error(with(R"("atmosphere": {"turbidity": 0.5})"), "atmosphere.turbidity", "0.5", "1.7");
    expect_error(with(R"("atmosphere": {"ground_albedo": [0.1, 0.2]})"), "atmosphere.ground_albedo", "[0.1,0.2]",
                 "three");
    expect_error(with(R"("atmosphere": {"ground_albedo": [0.1, 0.2, 2]})"), "atmosphere.ground_albedo[2]", "2", "1.0");
    expect_error(with(R"("atmosphere": {"model": "hosek"})"), "atmosphere.model", "hosek",
                 "preetham, perez, cie-clear, cie-overcast, asrc-cie, cie-general or scattering");
    expect_error(with(R"("atmosphere": {"model": "cie-general", "cie_type": 16})"), "atmosphere.cie_type", "16", "15");
    expect_error(with(R"("atmosphere": {"model": "cie-general", "cie_type": 2.5})"), "atmosphere.cie_type", "2.5",
                 "a whole number");
    expect_error(with(R"("atmosphere": {"model": "perez", "brightness": 0.7})"), "atmosphere.brightness", "0.7", "0.6");
    expect_error(with(R"("atmosphere": {"model": "asrc-cie", "clearness": 0})"), "atmosphere.clearness", "0", "1.0");
    // A parameter that the model does not read would change nothing.
    expect_error(with(R"("atmosphere": {"model": "scattering", "clearness": 3})"), "atmosphere.clearness",
                 "unknown field", "one of model, turbidity");
    expect_error(with(R"("chart": {"show": "night"})"), "chart.show", "night", "none, sky or day");
    expect_error(with(R"("chart": {"bands": 8})"), "chart.bands", "8", "7");
    expect_error(with(R"("chart": {"filter": "box"})"), "chart.filter", "box", "least-blur or sinc");
    expect_error(with(R"("camera": {"fov_deg": 0})"), "camera.fov_deg", "0", "5.0");
    expect_error(with(R"("camera": 5)"), "camera", "5", "an object");
    expect_error(with(R"("exposure": {"bias": 1})"), "exposure.bias", "unknown", "bias_ev");
    expect_error(with(R"("turbidity": 3)"), "turbidity", "unknown", "atmosphere");
    expect_error(with(R"("quality": "ultra")"), "quality", "ultra", "lean");
    expect_error(with(R"("time_rate": -1)"), "time_rate", "-1", "0.0");
    expect_error(with(R"("name": "again")"), "name", "twice", "once");
    expect_error(replaced("2026-06-21T05:30:00Z", "-5000-01-01T00:00:00Z"), "time_utc", "5000", "year");
    expect_error(replaced("2026-06-21T05:30:00Z", "10000-01-01T00:00:00Z"), "time_utc", "10000", "year");
    expect_error(replaced("2026-06-21T05:30:00Z", "yesterday"), "time_utc", "yesterday", "");
    expect_error(replaced("2026-06-21T05:30:00Z", "2026-02-30T05:30:00Z"), "time_utc", "30", "");
    expect_error(replaced(R"("name": "test",)", ""), "name", "missing", "");
    expect_error(replaced(R"(, "longitude_deg": 11.39)", ""), "observer.longitude_deg", "missing", "");
    expect_error("[1, 2]", "", "[1,2]", "object");
}

TEST(Scene, MalformedJsonNamesLineAndColumn) {
    expect_error("{\n  \"name\": \"a\"\n  \"b\": 1\n}", "line 3, column 5", "malformed", "");
    expect_error("", "line 1, column 1", "malformed", "");
    expect_error(replaced("47.27", "NaN"), "line 4", "malformed", "");
    expect_error(replaced("47.27", "1e999"), "", "1e999", "");
    expect_error(good.substr(0, good.size() - 2), "line 4", "malformed", "");
    expect_error("{\"a\": \"\xff\"}", "line 1", "malformed", "");
    expect_error(std::string(2000, '['), "line 1", "malformed", "");
}

TEST(Scene, LoadsFilesAndSaysWhichItCannot) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(testing::TempDir()) / "alpenglow-scene-test";
    fs::create_directories(folder);
    const fs::path file = folder / "mine.json";
    std::ofstream(file) << good;
    const Result<Scene> scene = load_scene(file.string());
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->name, "test");

    const Result<Scene> unknown = load_scene("alpine-mourning");
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message().find("alpine-mourning"), std::string::npos);
    EXPECT_NE(unknown.error().message().find("alpine-morning"), std::string::npos); // what there is
    const Result<Scene> missing = load_scene((folder / "none.json").string());
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message().find("no such file"), std::string::npos);
    ASSERT_FALSE(load_scene(folder.string()));
    ASSERT_FALSE(load_scene(""));
    const fs::path large = folder / "large.json";
    std::ofstream(large) << std::string(2U << 20U, ' ');
    ASSERT_FALSE(load_scene(large.string()));
    fs::remove_all(folder);
}

} // namespace
} // namespace alpenglow::sandbox
