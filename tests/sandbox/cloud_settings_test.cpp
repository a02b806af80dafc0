#include <gtest/gtest.h>

#include <string>

#include "sandbox/scene/scene.hpp"

namespace alpenglow::sandbox {
namespace {

std::string with(const std::string& sections) {
    return R"({"name": "x", "time_utc": "2026-07-12T13:30:00Z", "observer": {"latitude_deg": 47, "longitude_deg": 11}, )" +
           sections + "}";
}

void expect_error(const std::string& sections, const char* where, const char* value, const char* expected) {
    const Result<Scene> scene = parse_scene(with(sections), "x.json");
    ASSERT_FALSE(scene) << sections;
    const std::string message = scene.error().message();
    for (const char* part : {"x.json", where, value, expected}) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
}

TEST(CloudSettings, ReadsEveryField) {
    const Result<Scene> scene = parse_scene(
        with(R"("clouds": {"layers": [{"type": "stratus", "cover": 1, "base_m": 900, "top_m": 1400, "extent_m": 9000,
              "voxel_m": 50, "seed": 7, "extinction_per_m": 0.02, "albedo": 0.9, "anisotropy": 0.5}, {}],
              "files": [{"path": "a.vdb", "grid": "d", "position_m": [1, 2, 3], "scale": 4}],
              "wind_m_s": 3, "wind_from_deg": 90, "method": "harris", "shadows": false})"),
        "folder/x.json");
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_TRUE(scene->clouds);
    const CloudSettings& clouds = *scene->clouds;
    ASSERT_EQ(clouds.layers.size(), 2U);
    EXPECT_EQ(clouds.layers[0].type, CloudLayerType::stratus);
    EXPECT_EQ(clouds.layers[0].seed, 7);
    EXPECT_EQ(clouds.layers[0].matter.albedo, 0.9F);
    EXPECT_EQ(clouds.layers[1].type, CloudLayerType::cumulus);
    ASSERT_EQ(clouds.files.size(), 1U);
    EXPECT_EQ(clouds.files[0].path, "a.vdb");
    EXPECT_EQ(clouds.files[0].position_m, glm::vec3(1, 2, 3));
    EXPECT_EQ(clouds.folder, "folder");
    EXPECT_EQ(clouds.wind_from_deg, 90.0F);
    EXPECT_EQ(clouds.method, 1);
    EXPECT_FALSE(clouds.shadows);
    EXPECT_FALSE(parse_scene(with(R"("exposure": {})"), "x.json")->clouds);
}

TEST(CloudSettings, ErrorsNameFileFieldValueAndWhatWouldBeRight) {
    expect_error(R"("clouds": {"layers": {}})", "clouds.layers", "{}", "an array of objects");
    expect_error(R"("clouds": {"layers": [3]})", "clouds.layers[0]", "3", "an object");
    expect_error(R"("clouds": {"layers": [{}, {"type": "fog"}]})", "clouds.layers[1].type", "fog", "cirrus");
    expect_error(R"("clouds": {"layers": [{"cover": 1.5}]})", "clouds.layers[0].cover", "1.5", "0.0 to 1.0");
    expect_error(R"("clouds": {"layers": [{"base_m": 900, "top_m": 900}]})", "clouds.layers[0].top_m", "900",
                 "above base_m");
    expect_error(R"("clouds": {"layers": [{"extent_m": 90000, "voxel_m": 10, "top_m": 9000}]})",
                 "clouds.layers[0].voxel_m", "10", "extent_m / 2048");
    expect_error(R"("clouds": {"files": [{"grid": "density"}]})", "clouds.files[0].path", "missing", "must be given");
    expect_error(R"("clouds": {"files": [{"path": "a.vdb", "size": 1}]})", "clouds.files[0].size", "unknown field",
                 "one of path");
    expect_error(R"("clouds": {"method": "magic"})", "clouds.method", "magic", "transport");
    expect_error(R"("flight": {})", "flight.keys", "missing", "must be given");
    expect_error(R"("flight": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]})", "flight.keys", "1 long",
                 "two keys");
    expect_error(
        R"("flight": {"keys": [{"time_s": 5, "position_m": [0, 0, 0]}, {"time_s": 5, "position_m": [0, 0, 0]}]})",
        "flight.keys[1].time_s", "5", "more than the key before");
}

} // namespace
} // namespace alpenglow::sandbox
