// Bad input: a clear message, the right exit code, no partial file.
#include <fstream>

#include "program.hpp"

namespace alpenglow::test {
namespace {

class BadInput : public ProgramTest {
protected:
    // Expects exit code 2 and a message that names every word; nothing may be left behind.
    void refuse(const std::string& arguments, const std::vector<std::string>& words) {
        const std::size_t before = files();
        const Outcome outcome = run_sandbox("--headless --out " + in_folder("picture.png") + " " + arguments);
        EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.output;
        for (const std::string& word : words) {
            EXPECT_NE(outcome.output.find(word), std::string::npos)
                << arguments << ": '" << word << "' is not in: " << outcome.output;
        }
        EXPECT_EQ(files(), before) << arguments;
    }
    std::string scene_file(const std::string& name, const std::string& json) {
        std::ofstream(in_folder(name)) << json;
        return in_folder(name);
    }
};

TEST_F(BadInput, UnknownScene) {
    refuse("--scene nowhere", {"nowhere", "alpine-morning"});
}
TEST_F(BadInput, UnknownOption) {
    refuse("--sceen noon", {"--sceen"});
}

TEST_F(BadInput, MalformedJson) {
    refuse("--scene " + scene_file("broken.json", "{ \"name\": \"x\", "), {"broken.json", "JSON"});
    refuse("--scene " + scene_file("empty.json", ""), {"empty.json"});
}

TEST_F(BadInput, WrongFieldOfAScene) {
    refuse("--scene " + scene_file("thin.json", R"({"name": "thin", "time_utc": "2026-06-21T05:30:00Z",
        "observer": {"latitude_deg": 47, "longitude_deg": 11}, "atmosphere": {"turbidity": 0.5}})"),
           {"thin.json", "turbidity", "0.5"});
    refuse("--scene " + scene_file("typed.json", R"({"name": "typed", "time_utc": 7,
        "observer": {"latitude_deg": 47, "longitude_deg": 11}})"),
           {"typed.json", "time_utc"});
}

TEST_F(BadInput, PlaceOffTheEarth) {
    refuse("--lat 91", {"--lat", "91", "90"});
    refuse("--lat nan", {"--lat", "nan"});
    refuse("--lon 1000", {"--lon", "1000"});
}

TEST_F(BadInput, DatesOutOfRange) {
    refuse("--time=-5000-01-01T00:00:00Z", {"--time", "-5000"});
    refuse("--time +10000-01-01T00:00:00Z", {"--time", "10000"});
    refuse("--time yesterday", {"--time", "yesterday"});
    refuse("--time 2026-02-30", {"--time", "30"});
}

TEST_F(BadInput, Sizes) {
    refuse("--size 0x0", {"--size", "0x0"});
    refuse("--size 100000x100000", {"--size", "100000x100000"});
    refuse("--size big", {"--size", "big"});
    refuse("--frames -1", {"--frames", "-1"});
}

TEST_F(BadInput, PathsThatCannotBeWritten) {
    const Outcome outcome = run_sandbox("--headless --out " + in_folder("no/such/folder/picture.png"));
    EXPECT_EQ(outcome.code, 2) << outcome.output;
    EXPECT_NE(outcome.output.find("no/such/folder"), std::string::npos) << outcome.output;
    const Outcome report = run_sandbox("--headless --report " + in_folder("no/such/folder/report.json"));
    EXPECT_EQ(report.code, 2) << report.output;
    EXPECT_EQ(files(), 0U);
}

TEST_F(BadInput, NoVulkanDevice) {
    const Outcome outcome = run_sandbox("--headless --out " + in_folder("picture.png"),
                                        "VK_DRIVER_FILES=/nonexistent.json VK_ICD_FILENAMES=/nonexistent.json");
    EXPECT_EQ(outcome.code, 3) << outcome.output;
    EXPECT_NE(outcome.output.find("device"), std::string::npos) << outcome.output;
    const Outcome named = run_sandbox("--headless --device no-such-gpu --out " + in_folder("picture.png"));
    EXPECT_EQ(named.code, 3) << named.output;
    EXPECT_NE(named.output.find("no-such-gpu"), std::string::npos) << named.output;
    EXPECT_EQ(files(), 0U);
}

TEST_F(BadInput, NoDisplayFallsBackToHeadlessAndSaysSo) {
    const Outcome outcome = run_sandbox("--scene noon --frames 1 --size 64x36 --out " + in_folder("picture.png"),
                                        "-u DISPLAY -u WAYLAND_DISPLAY");
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("headless"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("picture.png"), std::string::npos) << outcome.output;
    EXPECT_EQ(load_picture(in_folder("picture.png")).width, 64);
}

TEST_F(ProgramTest, HelpAndScenesAreListed) {
    const Outcome help = run_sandbox("--help");
    EXPECT_EQ(help.code, 0);
    for (const char* option : {"--scene", "--headless", "--frames", "--size", "--time", "--lat", "--lon", "--out",
                               "--report", "--validate", "--list-scenes", "--help"}) {
        EXPECT_NE(help.output.find(option), std::string::npos) << option;
    }
    const Outcome scenes = run_sandbox("--list-scenes");
    EXPECT_EQ(scenes.code, 0);
    for (const char* scene :
         {"alpine-morning", "noon", "sunset", "full-moon-night", "southern-summer", "polar-summer", "probes"}) {
        EXPECT_NE(scenes.output.find(scene), std::string::npos) << scene;
    }
}

} // namespace
} // namespace alpenglow::test
