#include "sandbox/render/hud.hpp"

#include <array>

#include <gtest/gtest.h>

#include <imgui.h>

namespace alpenglow::sandbox {
namespace {

// ImGui without a window: enough of a backend to make draw data.
class HudTest : public testing::Test {
protected:
    void SetUp() override {
        context = ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {640.0F, 360.0F};
        unsigned char* pixels = nullptr;
        int width = 0;
        int height = 0;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    }
    void TearDown() override { ImGui::DestroyContext(context); }

    // A frame with windows of the given left edges, each 100 x 80, and a text in the first.
    ImDrawData& draw(const std::vector<float>& lefts, const char* text) {
        constexpr std::array<const char*, 2> names{"first", "second"};
        for (int i = 0; i < 2; ++i) { // a window takes its size in its second frame
            ImGui::NewFrame();
            int number = 0;
            for (const float left : lefts) {
                ImGui::SetNextWindowPos({left, 50.0F});
                ImGui::SetNextWindowSize({100.0F, 80.0F});
                ImGui::Begin(names[static_cast<std::size_t>(number)], nullptr, ImGuiWindowFlags_NoDecoration);
                ImGui::TextUnformatted(number++ == 0 ? text : "-");
                ImGui::End();
            }
            ImGui::Render();
        }
        return *ImGui::GetDrawData();
    }

    ImGuiContext* context = nullptr;
};

TEST_F(HudTest, HashTellsPicturesApart) {
    const std::uint64_t first = hud_hash(draw({10.0F}, "12 fps"));
    EXPECT_EQ(hud_hash(draw({10.0F}, "12 fps")), first);
    EXPECT_NE(hud_hash(draw({10.0F}, "13 fps")), first);
    EXPECT_NE(hud_hash(draw({11.0F}, "12 fps")), first);
}

TEST_F(HudTest, RectanglesHoldTheWindowsAndDoNotOverlap) {
    const std::vector<HudRectangle> apart = hud_rectangles(draw({10.0F, 300.0F}, "x"), {640, 360});
    ASSERT_EQ(apart.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        const int left = i == 0 ? 10 : 300;
        EXPECT_LE(apart[i].left, left);
        EXPECT_GE(apart[i].right, left + 100);
        EXPECT_LE(apart[i].right, left + 110);
        EXPECT_LE(apart[i].top, 50);
        EXPECT_GE(apart[i].bottom, 130);
        EXPECT_LE(apart[i].bottom, 140);
    }
    const std::vector<HudRectangle> merged = hud_rectangles(draw({10.0F, 80.0F}, "x"), {640, 360});
    ASSERT_EQ(merged.size(), 1U);
    EXPECT_GE(merged[0].right, 180);
}

TEST_F(HudTest, RectanglesStayInTheImage) {
    for (const HudRectangle& r : hud_rectangles(draw({-60.0F, 600.0F}, "x"), {640, 360})) {
        EXPECT_GE(r.left, 0);
        EXPECT_LE(r.right, 640);
        EXPECT_LT(r.left, r.right);
    }
}

TEST_F(HudTest, NothingDrawnHasNoRectangles) {
    EXPECT_TRUE(hud_rectangles(draw({}, ""), {640, 360}).empty());
}

} // namespace
} // namespace alpenglow::sandbox
