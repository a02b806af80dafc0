// The scene `squadron` from outside: pictures by impostors against pictures by marching every cloud.
#include <string>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace alpenglow::test {
namespace {

class ImpostorPictures : public ProgramTest {
protected:
    nlohmann::json fly(const std::string& more) {
        const Outcome outcome = run_sandbox("--headless --scene squadron --size 384x216 --out " + in_folder("p.png") +
                                            " --report " + in_folder("r.json") + " " + more);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        return nlohmann::json::parse(read_file(in_folder("r.json")));
    }
};

TEST_F(ImpostorPictures, HoldFortyDecibelsAgainstDirectDrawing) {
    const nlohmann::json report = fly("--frames 150 --compare 25");
    int compared = 0;
    for (const nlohmann::json& frame : report["frames"]) {
        if (frame["systems"].contains("compare") && frame["index"] >= 60) { // by then every cloud has its picture
            EXPECT_GE(frame["systems"]["compare"]["error_bound"], 40.0) << "frame " << frame["index"];
            ++compared;
        }
    }
    EXPECT_EQ(compared, 4);
    EXPECT_FALSE(read_file(in_folder("p-difference.png")).empty());
}

TEST_F(ImpostorPictures, NoValidationMessages) {
    for (const char* quality : {"lean", "full"}) {
        const Outcome outcome =
            run_sandbox("--headless --scene squadron --size 192x108 --frames 6 --validate --quality " +
                        std::string(quality) + " --out " + in_folder("p.png"));
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_NE(outcome.output.find("0 messages"), std::string::npos) << outcome.output;
    }
}

TEST_F(ImpostorPictures, CompareAsksForAWholeNumber) {
    const Outcome outcome = run_sandbox("--headless --scene squadron --compare soon --out " + in_folder("p.png"));
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.output.find("--compare"), std::string::npos) << outcome.output;
}

} // namespace
} // namespace alpenglow::test
