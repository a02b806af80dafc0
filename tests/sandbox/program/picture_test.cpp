// Pictures and reports of the scenes.
#include <algorithm>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace alpenglow::test {
namespace {

class Pictures : public ProgramTest {
protected:
    Picture render(const std::string& scene, const std::string& more = "") {
        const Outcome outcome =
            run_sandbox("--headless --size 320x180 --scene " + scene + " --out " + in_folder("p.png") + " " + more);
        EXPECT_EQ(outcome.code, 0) << scene << ": " << outcome.output;
        return load_picture(in_folder("p.png"));
    }
};

double luma(const std::vector<double>& rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

TEST_F(Pictures, NoonSkyIsBlueAndTheHorizonIsBrighterThanTheZenith) {
    const Picture noon = render("noon");
    const auto top = noon.mean(0.0, 0.0, 1.0, 0.1);
    EXPECT_GT(top[2], top[0] + 10.0);
    EXPECT_GT(luma(noon.mean(0.0, 0.0, 1.0, 1.0)), 50.0);
}

TEST_F(Pictures, SunsetIsWarmerThanNoon) {
    const auto noon = render("noon").mean(0.0, 0.0, 1.0, 1.0);
    const auto sunset = render("sunset").mean(0.0, 0.0, 1.0, 1.0);
    EXPECT_GT(sunset[0] / sunset[2], noon[0] / noon[2]);
}

TEST_F(Pictures, NightIsDarkButNotBlack) {
    const auto night = render("full-moon-night").mean(0.0, 0.0, 1.0, 1.0);
    const auto noon = render("noon").mean(0.0, 0.0, 1.0, 1.0);
    EXPECT_LT(luma(night), 0.7 * luma(noon));
    EXPECT_GT(luma(night), 3.0);
}

TEST_F(Pictures, SameBytesTwiceAndWithAnyNumberOfThreads) {
    const auto expect_same = [&](const char* scene, std::initializer_list<const char*> environments) {
        std::string first;
        for (const char* environment : environments) {
            const Outcome outcome = run_sandbox("--headless --frames 3 --size 320x180 --scene " + std::string(scene) +
                                                    " --out " + in_folder("p.png"),
                                                environment);
            ASSERT_EQ(outcome.code, 0) << outcome.output;
            const std::string bytes = read_file(in_folder("p.png"));
            ASSERT_FALSE(bytes.empty());
            if (first.empty()) {
                first = bytes;
            }
            EXPECT_EQ(bytes == first, true) << scene << ' ' << environment;
        }
    };
    expect_same("alpine-morning", {"LP_NUM_THREADS=0", "LP_NUM_THREADS=0", "LP_NUM_THREADS=1", "LP_NUM_THREADS=2",
                                   "LP_NUM_THREADS=2 ALPENGLOW_THREADS=1", "LP_NUM_THREADS=1 ALPENGLOW_THREADS=3"});
    // With clouds, pictures of them, probes and transfer.
    expect_same("valley-afternoon", {"LP_NUM_THREADS=0 ALPENGLOW_THREADS=3", "LP_NUM_THREADS=2 ALPENGLOW_THREADS=1"});
}

TEST_F(Pictures, AStaticSceneRecomputesAndUploadsNothing) {
    const Outcome outcome = run_sandbox("--headless --scene alpine-morning --frames 6 --size 320x180 --out " +
                                        in_folder("p.png") + " --report " + in_folder("r.json"));
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const auto report = nlohmann::json::parse(read_file(in_folder("r.json")));
    ASSERT_EQ(report["frames"].size(), 6U);
    // At the rate of real time the first tenth of a second is within every budget.
    for (std::size_t i = 1; i < 6; ++i) {
        for (const auto& [name, system] : report["frames"][i]["systems"].items()) {
            EXPECT_EQ(system["updated"], 0) << name << " in frame " << i;
        }
    }
    for (const char* field : {"considered", "updated", "skipped", "cpu_ms", "error_bound"}) {
        EXPECT_TRUE(report["medians"]["systems"]["ephemeris"].contains(field)) << field;
    }
    EXPECT_GT(report["medians"]["cpu_ms"], 0.0);
    EXPECT_GT(report["medians"]["wall_ms"], 0.0);
}

TEST_F(Pictures, ValidationIsSilentInBothQualities) {
    for (const char* quality : {"lean", "full"}) {
        for (const char* scene : {"alpine-morning", "full-moon-night", "probes"}) {
            const Outcome outcome =
                run_sandbox("--headless --validate --frames 3 --size 192x108 --hud --quality " + std::string(quality) +
                            " --scene " + scene + " --out " + in_folder("p.png"));
            EXPECT_EQ(outcome.code, 0) << quality << " " << scene << ": " << outcome.output;
            EXPECT_NE(outcome.output.find("validation: 0 messages"), std::string::npos) << outcome.output;
        }
    }
}

TEST_F(Pictures, AWindowOpensDrawsAndCloses) {
    if (std::system("command -v xvfb-run >/dev/null") != 0) {
        GTEST_SKIP() << "needs xvfb-run";
    }
    const std::string command = "xvfb-run -a " ALPENGLOW_SANDBOX
                                " --validate --scene noon --frames 10 --size 320x180 --out " +
                                in_folder("w.png") + " 2>" + in_folder("log");
    EXPECT_EQ(std::system(command.c_str()), 0) << read_file(in_folder("log"));
    EXPECT_NE(read_file(in_folder("log")).find("validation: 0 messages"), std::string::npos);
    EXPECT_EQ(load_picture(in_folder("w.png")).width, 320);
}

} // namespace
} // namespace alpenglow::test
