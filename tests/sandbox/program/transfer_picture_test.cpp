// Scene `transfer` on a device: both evaluations of the tables show the same.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace alpenglow::test {
namespace {

class TransferPictures : public ProgramTest {
protected:
    Picture render(const std::string& quality, const std::string& path, const std::string& level) {
        std::ofstream(in_folder("scene.json"))
            << R"({"name": "t", "time_utc": "2026-09-12T15:25:00Z", "observer": {"latitude_deg": 47.27, "longitude_deg": 11.39},
                 "camera": {"position_m": [348.2, -107.6, 592.35], "yaw_deg": 0, "pitch_deg": -6, "fov_deg": 52},
                 "transfer": {"detail": 0.1, "path": ")"
            << path << R"(", "level": ")" << level << R"("}})";
        const Outcome outcome = run_sandbox("--headless --validate --frames 3 --size 320x180 --quality " + quality +
                                                " --scene " + in_folder("scene.json") + " --out " + in_folder("p.png") +
                                                " --report " + in_folder("r.json"),
                                            "XDG_CACHE_HOME=" + in_folder("cache"));
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_NE(outcome.output.find("validation: 0 messages"), std::string::npos) << outcome.output;
        return load_picture(in_folder("p.png"));
    }
    static int difference(const Picture& a, const Picture& b) { // the largest
        int most = a.rgb.size() == b.rgb.size() ? 0 : 255;
        for (std::size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); ++i) {
            most = std::max(most, std::abs(static_cast<int>(a.rgb[i]) - static_cast<int>(b.rgb[i])));
        }
        return most;
    }
};

TEST_F(TransferPictures, ShaderAndCpuShowTheSame) {
    for (const char* quality : {"lean", "full"}) {
        const Picture cpu = render(quality, "cpu", "interreflected");
        const Picture shader = render(quality, "shader", "interreflected");
        EXPECT_LE(difference(cpu, shader), 2) << quality; // of 255: rounding
    }
}

TEST_F(TransferPictures, TheLevelsDiffer) {
    const Picture open = render("lean", "cpu", "unshadowed");
    const Picture shadowed = render("lean", "cpu", "shadowed");
    const Picture bounced = render("lean", "cpu", "interreflected");
    EXPECT_GT(difference(open, shadowed), 40);
    EXPECT_GT(difference(shadowed, bounced), 8);
}

} // namespace
} // namespace alpenglow::test
