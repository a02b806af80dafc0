#include <gtest/gtest.h>

#include "support.hpp"

#include <alpenglow/probes/environment.hpp>
#include <alpenglow/probes/light_probe.hpp>

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace alpenglow::probes {
namespace {

class EnvironmentFile : public ::testing::Test {
protected:
    std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("alpenglow_environment_" + std::to_string(::getpid()) + ".hdr");

    void write(const std::string& bytes) const {
        std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    [[nodiscard]] std::string error() const {
        const Result<EnvironmentMap> map = load_environment(file);
        return map ? "loaded" : map.error().message();
    }
    void TearDown() override { std::filesystem::remove(file); }

    static std::string header(const std::string& size) {
        return "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n";
    }
    // Flat rows: mantissas 128, 64, 32 and the exponent of 1 are (0.5, 0.25, 0.125) times 2.
    static std::string flat(int pixels) {
        std::string data;
        for (int i = 0; i < pixels; ++i) {
            data += std::string("\x80\x40\x20\x82", 4);
        }
        return data;
    }
    static std::string runs(int width, int height) {
        std::string data;
        for (int row = 0; row < height; ++row) {
            data += std::string({2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)});
            for (const char value : {'\x80', '\x40', '\x20', '\x82'}) {
                for (int left = width; left > 0; left -= 127) {
                    data += std::string({static_cast<char>(128 + std::min(left, 127)), value});
                }
            }
        }
        return data;
    }
};

TEST_F(EnvironmentFile, FlatAndRunLengthCodedFilesLoad) {
    write(header("-Y 3 +X 4") + flat(12));
    const Result<EnvironmentMap> small = load_environment(file, 4);
    ASSERT_TRUE(small) << small.error().message();
    EXPECT_EQ(small->width, 4);
    EXPECT_EQ(small->height, 3);
    EXPECT_EQ(small->order, 4);
    EXPECT_EQ(small->radiance[11], glm::vec3(2.0F, 1.0F, 0.5F));
    write(header("-Y 8 +X 300") + runs(300, 8));
    const Result<EnvironmentMap> coded = load_environment(file);
    ASSERT_TRUE(coded) << coded.error().message();
    EXPECT_EQ(coded->radiance.size(), 2400U);
    EXPECT_EQ(coded->radiance[2399], glm::vec3(2.0F, 1.0F, 0.5F));
}

TEST_F(EnvironmentFile, ErrorsNameTheFileAndTheFault) {
    EXPECT_NE(error().find("cannot be read"), std::string::npos) << error();
    EXPECT_NE(error().find(file.string()), std::string::npos);
    write("");
    EXPECT_NE(error().find("is empty"), std::string::npos) << error();
    write("\x89PNG not a picture of this kind");
    EXPECT_NE(error().find("has no header of a Radiance image"), std::string::npos) << error();
    write("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 3 +X 4\n" + flat(12));
    EXPECT_NE(error().find("no header"), std::string::npos) << error();
    write(header("+X 4 -Y 3") + flat(12));
    EXPECT_NE(error().find("no header"), std::string::npos) << error();
    write(header("-Y 0 +X 4"));
    EXPECT_NE(error().find("size of 4 x 0"), std::string::npos) << error();
    write(header("-Y 3 +X -4") + flat(12));
    EXPECT_NE(error().find("size of -4 x 3"), std::string::npos) << error();
    write(header("-Y 3 +X 4") + flat(11));
    EXPECT_NE(error().find("ends before all of its 4 x 3 pixels"), std::string::npos) << error();
    write(header("-Y 100000 +X 100000") + flat(12));
    EXPECT_NE(error().find("which takes"), std::string::npos) << error();
    write(header("-Y 2 +X 300") + std::string({2, 2, 1, 45}) + std::string(3000, '\x90'));
    EXPECT_NE(error().find("is damaged"), std::string::npos) << error();
}

// Wherever a file ends, the answer is an error, and it comes.
TEST_F(EnvironmentFile, EveryTruncationIsAnError) {
    const std::string coded = header("-Y 5 +X 300") + runs(300, 5);
    for (std::size_t length = 0; length < coded.size(); ++length) {
        write(coded.substr(0, length));
        EXPECT_NE(error(), "loaded") << length;
    }
    const std::string plain = header("-Y 2 +X 3") + flat(6);
    for (std::size_t length = 0; length < plain.size(); ++length) {
        write(plain.substr(0, length));
        EXPECT_NE(error(), "loaded") << length;
    }
}

TEST_F(EnvironmentFile, DamagedBytesNeverHang) {
    const std::string good = header("-Y 5 +X 300") + runs(300, 5);
    std::mt19937 engine(1);
    for (int trial = 0; trial < 300; ++trial) {
        std::string bad = good;
        for (int k = 0; k < 4; ++k) {
            bad[engine() % bad.size()] = static_cast<char>(engine());
        }
        write(bad);
        const Result<EnvironmentMap> map = load_environment(file);
        EXPECT_TRUE(map || !map.error().what.empty());
    }
}

EnvironmentMap map_of(int width, int height, const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
    EnvironmentMap map;
    map.width = width;
    map.height = height;
    map.order = max_probe_order;
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            const double theta = pi * (v + 0.5) / height;
            const double phi = two_pi * (u + 0.5) / width;
            map.radiance.emplace_back(radiance(
                glm::dvec3(-std::sin(theta) * std::sin(phi), -std::sin(theta) * std::cos(phi), std::cos(theta))));
        }
    }
    return map;
}

TEST(EnvironmentMapTest, ChecksNameTheFieldAndThePixel) {
    EnvironmentMap map = map_of(8, 4, [](const glm::dvec3&) { return glm::dvec3(1.0); });
    EXPECT_TRUE(check(map));
    map.radiance[8 * 2 + 5].y = std::nanf("");
    ASSERT_FALSE(check(map));
    EXPECT_NE(check(map).error().message().find("radiance: at column 5, row 2 is nan"), std::string::npos)
        << check(map).error().message();
    map.radiance[8 * 2 + 5].y = -1.0F;
    EXPECT_FALSE(check(map));
    map = map_of(8, 4, [](const glm::dvec3&) { return glm::dvec3(1.0); });
    map.radiance.pop_back();
    EXPECT_NE(check(map).error().message().find("has 31 pixels"), std::string::npos);
    map.width = 0;
    EXPECT_NE(check(map).error().message().find("width: is 0"), std::string::npos);
}

TEST(EnvironmentMapTest, AConstantStaysConstant) {
    for (const int height : {1, 2, 16, 128}) {
        const EnvironmentMap map = map_of(2 * height, height, [](const glm::dvec3&) { return glm::dvec3(3.0); });
        ProbeCoefficients c{};
        project_environment(map, c);
        EXPECT_NEAR(c[0].x, 3.0 * std::sqrt(4.0 * pi), 1e-5) << height;
        for (std::size_t i = 1; i < 25; ++i) {
            EXPECT_LE(glm::length(c[i]), 1e-5) << i;
        }
    }
}

TEST(EnvironmentMapTest, BandLimitedLightComesBackTurned) {
    std::mt19937 engine(4);
    std::normal_distribution<double> normal;
    std::vector<double> c(25);
    for (double& v : c) {
        v = 0.1 * normal(engine);
    }
    c[0] = 10.0;
    EnvironmentMap map = map_of(256, 128, [&](const glm::dvec3& d) { return glm::dvec3(sh::evaluate(5, c, d)); });
    ProbeCoefficients out{};
    project_environment(map, out);
    for (std::size_t i = 0; i < 25; ++i) {
        EXPECT_NEAR(out[i].x, c[i], 4e-3) << i;
    }
    map.azimuth_rad = static_cast<float>(0.5 * pi);
    map.scale = 2.0F;
    project_environment(map, out);
    EXPECT_NEAR(out[3].x, 2.0 * c[1], 4e-3); // what was north is east
    EXPECT_NEAR(out[2].x, 2.0 * c[2], 4e-3);
    const glm::vec3 d = glm::normalize(glm::vec3(0.3F, -0.8F, 0.4F));
    EXPECT_NEAR(environment_radiance(map, d).x, sh::evaluate(5, std::span<const glm::vec3>(out), d).x, 0.02);
}

TEST(EnvironmentMapTest, BackgroundIsSeamlessAndHeldAtThePoles) {
    const EnvironmentMap map =
        map_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(2.0 + d.x, 2.0 + d.y, 2.0 + d.z); });
    const glm::vec3 a = environment_radiance(map, glm::normalize(glm::vec3(1e-6F, -1.0F, 0.0F)));
    const glm::vec3 b = environment_radiance(map, glm::normalize(glm::vec3(-1e-6F, -1.0F, 0.0F)));
    EXPECT_LE(glm::distance(a, b), 1e-4F);
    EXPECT_NEAR(environment_radiance(map, {0.0F, 0.0F, 1.0F}).z, 3.0F, 0.01F);
    EXPECT_NEAR(environment_radiance(map, {0.0F, 0.0F, -1.0F}).z, 1.0F, 0.01F);
}

TEST(EnvironmentMapTest, UpdatesOnceAndDeringsForReceivers) {
    const EnvironmentMap map = map_of(64, 32, [](const glm::dvec3& d) {
        return glm::dvec3(d.x > 0.98 ? 5000.0 : 1.0); // a small bright lamp
    });
    EnvironmentMapSh light;
    EXPECT_EQ(update_environment(map, light, false).updated, 0U);
    EXPECT_EQ(update_environment(map, light, true).updated, 1U);
    EXPECT_EQ(update_environment(map, light, true).updated, 0U);
    EXPECT_LT(test::least_irradiance(5, light.coefficients), -1e-3);
    EXPECT_GE(test::least_irradiance(5, light.deringed), -1e-4);
}

} // namespace
} // namespace alpenglow::probes
