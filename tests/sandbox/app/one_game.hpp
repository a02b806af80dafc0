// One game for all tests of a suite: the landscape takes a while to load, and scenes are entered at once.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string_view>

#include "sandbox/app/game.hpp"
#include "sandbox/world/landscape_file.hpp"

namespace alpenglow::sandbox {

class OneGame : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        const std::filesystem::path file = built_landscape();
        game_ = new Game(*load_scene("noon"), open_world(std::span(&file, 1)).world);
    }
    static void TearDownTestSuite() {
        delete game_;
        game_ = nullptr;
    }
    // Of the last update; null where that system did not run.
    static const SystemReport* report(std::string_view system) {
        const auto reports = game_->reports();
        const auto at =
            std::find_if(reports.begin(), reports.end(), [&](const SystemReport& r) { return r.system == system; });
        return at == reports.end() ? nullptr : &*at;
    }
    static inline Game* game_ = nullptr;
};

} // namespace alpenglow::sandbox
