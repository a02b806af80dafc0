// Clouds from outside: the device's march against the CPU's.
#include <cmath>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace alpenglow::test {
namespace {

// Two layers, small and coarse, so that modelling and lighting take a moment.
nlohmann::json two_layers() {
    return {{"name", "two layers"},
            {"description", "of clouds"},
            {"observer", {{"latitude_deg", 47.27}, {"longitude_deg", 11.39}, {"height_m", 590}}},
            {"time_utc", "2026-07-12T15:30:00Z"},
            {"time_rate", 0},
            {"camera", {{"position_m", {-64, -4384, 1980}}, {"yaw_deg", -20}, {"pitch_deg", 7}, {"fov_deg", 50}}},
            {"clouds",
             {{"layers",
               {{{"type", "cumulus"},
                 {"cover", 0.3},
                 {"base_m", 2900},
                 {"top_m", 4200},
                 {"extent_m", 9000},
                 {"voxel_m", 90}},
                {{"type", "cirrus"},
                 {"cover", 0.4},
                 {"base_m", 7000},
                 {"top_m", 8000},
                 {"extent_m", 20000},
                 {"voxel_m", 200},
                 {"extinction_per_m", 0.004}}}}}}};
}

class CloudPictures : public ProgramTest {
protected:
    Picture render(const nlohmann::json& scene, const std::string& more, const std::string& environment = "",
                   const std::string& quality = "full") {
        std::ofstream(in_folder("scene.json")) << scene;
        const Outcome outcome =
            run_sandbox("--headless --size 320x180 --quality " + quality + " --scene " + in_folder("scene.json") +
                            " --out " + in_folder("p.png") + " --report " + in_folder("r.json") + " " + more,
                        environment);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        said_ = outcome.output;
        return load_picture(in_folder("p.png"));
    }
    std::string said_;
};

// Of display colours: relative RMSE.
double difference(const Picture& a, const Picture& b) {
    double square = 0.0;
    double energy = 0.0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        const double d = double(a.rgb[i]) - double(b.rgb[i]);
        square += d * d;
        energy += double(b.rgb[i]) * double(b.rgb[i]);
    }
    return std::sqrt(square / energy);
}

TEST_F(CloudPictures, TheDevicesMarchIsTheCpus) {
    nlohmann::json scene = two_layers();
    const Picture device = render(scene, "--frames 3 --validate");
    EXPECT_NE(said_.find("validation: 0 messages"), std::string::npos) << said_;
    const auto report = nlohmann::json::parse(read_file(in_folder("r.json")));
    for (const std::size_t frame : {std::size_t(1), std::size_t(2)}) { // nothing marched, nothing uploaded
        EXPECT_EQ(report["frames"][frame]["systems"]["cloud_view"]["updated"], 0);
        EXPECT_EQ(report["frames"][frame]["systems"]["draw"]["updated"], 0);
    }
    scene["clouds"]["march"] = "cpu";
    const Picture cpu = render(scene, "");
    scene["clouds"]["layers"] = nlohmann::json::array();
    const Picture clear = render(scene, "");
    ASSERT_EQ(device.rgb.size(), cpu.rgb.size());
    EXPECT_LT(difference(device, cpu), 0.01);
    EXPECT_GT(difference(clear, cpu), 10.0 * difference(device, cpu)); // there are clouds to speak of
}

TEST_F(CloudPictures, TheDevicesMarchDoesNotDependOnThreads) {
    const Picture one = render(two_layers(), "", "LP_NUM_THREADS=1 ALPENGLOW_THREADS=1");
    const Picture two = render(two_layers(), "", "LP_NUM_THREADS=2 ALPENGLOW_THREADS=3");
    EXPECT_TRUE(one.rgb == two.rgb);
}

// While the camera moves a ninth of the rays is marched: the picture is that of all of them within 40 dB.
TEST_F(CloudPictures, AFlightHoldsFortyDecibelsAgainstEveryRay) {
    nlohmann::json scene = two_layers();
    scene["time_rate"] = 1;
    scene["flight"] = {{"loop", false},
                       {"keys",
                        {{{"time_s", 0}, {"position_m", {-64, -4384, 3300}}, {"yaw_deg", -20}, {"pitch_deg", 2}},
                         {{"time_s", 1}, {"position_m", {-110, -4260, 3310}}, {"yaw_deg", -14}, {"pitch_deg", 3}}}}};
    render(scene, "--frames 40 --compare 7", "", "lean");
    const auto report = nlohmann::json::parse(read_file(in_folder("r.json")));
    int compared = 0;
    for (const nlohmann::json& frame : report["frames"]) {
        if (frame["systems"].contains("compare")) {
            EXPECT_GE(frame["systems"]["compare"]["error_bound"], 40.0) << "frame " << frame["index"];
            ++compared;
        }
    }
    EXPECT_GE(compared, 5);
}

} // namespace
} // namespace alpenglow::test
