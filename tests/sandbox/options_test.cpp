#include <sandbox/cli/options.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <initializer_list>

namespace alpenglow::sandbox {
namespace {

Result<Options> parse(std::initializer_list<const char*> arguments) {
    return parse_options({arguments.begin(), arguments.size()});
}

void expect_error(std::initializer_list<const char*> arguments, const std::string& option, const std::string& value,
                  const std::string& expected) {
    const Result<Options> options = parse(arguments);
    ASSERT_FALSE(options) << option << " " << value;
    const std::string message = options.error().message();
    EXPECT_NE(message.find(option), std::string::npos) << message;
    EXPECT_NE(message.find(value), std::string::npos) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
}

TEST(Options, DefaultsToPlayingTheDefaultScene) {
    const Result<Options> options = parse({});
    ASSERT_TRUE(options);
    EXPECT_EQ(options->scene, "valley-afternoon");
    EXPECT_FALSE(options->headless);
    EXPECT_EQ(options->frames, 0);
    EXPECT_EQ(options->width, 960);
    EXPECT_EQ(options->height, 540);
    EXPECT_FALSE(options->utc_j2000_s);
    EXPECT_FALSE(options->quality);
}

TEST(Options, ReadsEveryOption) {
    const Result<Options> options = parse({"--scene",  "noon",       "--headless",
                                           "--frames", "7",          "--size",
                                           "640x360",  "--time",     "2000-01-01T12:00:00Z",
                                           "--lat",    "-33.9",      "--lon=+18.4",
                                           "--out",    "a.png",      "--report",
                                           "r.json",   "--validate", "--quality",
                                           "full",     "--hud",      "--device",
                                           "llvmpipe", "--threads",  "2",
                                           "--chart",  "sky:7"});
    ASSERT_TRUE(options) << options.error().message();
    EXPECT_EQ(options->scene, "noon");
    EXPECT_TRUE(options->headless);
    EXPECT_EQ(options->frames, 7);
    EXPECT_EQ(options->width, 640);
    EXPECT_EQ(options->height, 360);
    EXPECT_EQ(options->utc_j2000_s, 0.0);
    EXPECT_EQ(options->latitude_deg, -33.9);
    EXPECT_EQ(options->longitude_deg, 18.4);
    EXPECT_EQ(options->out, "a.png");
    EXPECT_EQ(options->report, "r.json");
    EXPECT_TRUE(options->validate);
    EXPECT_EQ(options->quality, Quality::full);
    EXPECT_TRUE(options->hud);
    EXPECT_EQ(options->chart, Chart::sky);
    EXPECT_EQ(options->chart_bands, 7);
    EXPECT_EQ(options->device, "llvmpipe");
    EXPECT_EQ(options->threads, 2U);
    EXPECT_EQ(parse({"--headless"})->frames, 1);
    EXPECT_TRUE(parse({"--list-scenes"})->list_scenes);
    EXPECT_TRUE(parse({"--help"})->help);
    EXPECT_TRUE(parse({"-h"})->help);
}

TEST(Options, ErrorsNameOptionValueAndWhatWouldBeRight) {
    expect_error({"--size", "0x0"}, "--size", "0x0", "16");
    expect_error({"--size", "100000x100000"}, "--size", "100000x100000", "16384");
    expect_error({"--size", "640"}, "--size", "640", "WIDTHxHEIGHT");
    expect_error({"--size", "640x360x3"}, "--size", "640x360x3", "WIDTHxHEIGHT");
    expect_error({"--size", "-640x360"}, "--size", "-640x360", "WIDTHxHEIGHT");
    expect_error({"--size", "9999999999999999999x1"}, "--size", "9999999999999999999x1", "WIDTHxHEIGHT");
    expect_error({"--lat", "91"}, "--lat", "91", "-90 to 90");
    expect_error({"--lat", "nan"}, "--lat", "nan", "-90 to 90");
    expect_error({"--lon", "inf"}, "--lon", "inf", "-180 to 180");
    expect_error({"--lon", "12east"}, "--lon", "12east", "-180 to 180");
    expect_error({"--time", "-5000-01-01"}, "--time", "5000", "year");
    expect_error({"--time", "10000-01-01"}, "--time", "10000", "year");
    expect_error({"--time", "noon"}, "--time", "noon", "");
    expect_error({"--frames", "0"}, "--frames", "0", "1");
    expect_error({"--frames", "-3"}, "--frames", "-3", "1");
    expect_error({"--frames", "1.5"}, "--frames", "1.5", "whole");
    for (const char* chart : {"night", "sky:", "sky:0", "sky:8", "day:3", ""}) {
        expect_error({"--chart", chart}, "--chart", *chart == '\0' ? "empty" : chart,
                     "sky, sky:1 to sky:7, day or none");
    }
    expect_error({"--threads", "-1"}, "--threads", "-1", "0");
    expect_error({"--quality", "ultra"}, "--quality", "ultra", "lean");
    expect_error({"--out", "a.jpg"}, "--out", "a.jpg", ".png");
    expect_error({"--out", "a.png", "--report", "a.png"}, "--report", "a.png", "another");
    expect_error({"--scene", ""}, "--scene", "empty", "");
    expect_error({"--size", ""}, "--size", "empty", "WIDTHxHEIGHT");
    expect_error({"--fullscreen"}, "command line", "--fullscreen", "--help");
    expect_error({"alpine-morning"}, "command line", "alpine-morning", "--help");
    expect_error({"--scene"}, "command line", "--scene", "--help");
    expect_error({"--hud", "--lat", "1", "--lat", "2"}, "command line", "--lat", "--help");
}

TEST(Options, HelpNamesEveryOption) {
    const std::string help = help_text();
    for (const char* option :
         {"--scene", "--headless", "--frames", "--size", "--time", "--lat", "--lon", "--out", "--report", "--validate",
          "--list-scenes", "--help", "--quality", "--hud", "--device", "--threads", "--chart"}) {
        EXPECT_NE(help.find(option), std::string::npos) << option;
    }
}

TEST(CheckWritable, SaysWhereNothingCanBeWrittenAndLeavesNothing) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(testing::TempDir()) / "alpenglow-options-test";
    fs::remove_all(folder);
    fs::create_directories(folder);
    EXPECT_TRUE(check_writable("--out", (folder / "a.png").string()));
    EXPECT_TRUE(fs::is_empty(folder));
    std::ofstream(folder / "b.png") << "old";
    EXPECT_TRUE(check_writable("--out", (folder / "b.png").string()));
    std::ifstream kept(folder / "b.png");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), "old");

    const Status nowhere = check_writable("--out", (folder / "none" / "a.png").string());
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().message().find("--out"), std::string::npos);
    EXPECT_NE(nowhere.error().message().find("folder"), std::string::npos);
    EXPECT_FALSE(check_writable("--out", folder.string()));
    EXPECT_FALSE(check_writable("--out", (folder / "b.png" / "c.png").string()));
    EXPECT_FALSE(check_writable("--out", "/proc/alpenglow.png"));
    fs::remove_all(folder);
}

} // namespace
} // namespace alpenglow::sandbox
