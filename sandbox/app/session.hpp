// A running game on a device: the loop of a window, or a row of headless frames.
#pragma once

#include <memory>
#include <optional>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/instance.hpp>
#include <alpenglow/vulkan/swapchain.hpp>

#include "sandbox/app/game.hpp"
#include "sandbox/app/panel.hpp"
#include "sandbox/app/report.hpp"
#include "sandbox/app/window.hpp"
#include "sandbox/cli/options.hpp"
#include "sandbox/render/renderer.hpp"

struct ImGuiContext;
struct ImDrawData;

namespace alpenglow::sandbox {

struct Session {
    // `window` is null for headless runs; `surface` belongs to it.
    static Result<std::unique_ptr<Session>> create(const vulkan::Instance& instance, const vulkan::Device& device,
                                                   const Scene& scene, const Options& options, Window* window,
                                                   VkSurfaceKHR surface);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // Renders frames a sixtieth of a second apart, whatever time they take.
    Status render(int frames);
    // Runs until the window is closed, or for Options::frames frames.
    Status play();

    std::unique_ptr<Game> game;
    std::unique_ptr<Renderer> renderer;
    RunReport report;
    // RGBA of the last comparison (Options::compare), amplified; empty: none.
    [[nodiscard]] const std::vector<std::byte>& difference() const { return difference_; }

private:
    Session() = default;
    void tell_problems();
    ImDrawData* draw_hud();
    Status draw(double dt_s);
    Status act(const Input& input, double dt_s);
    Status fit_window();
    Status compare();

    const vulkan::Device* device_ = nullptr;
    Window* window_ = nullptr;
    std::optional<vulkan::Swapchain> swapchain_;
    PanelState panel_;
    ImGuiContext* imgui_ = nullptr; // null where no panel is drawn
    int frames_until_refresh_ = 0;
    Options options_;
    double speed_m_s_ = 60.0;
    double stopped_rate_ = 1.0; // the rate to go on with after Space
    int screenshots_ = 0;
    std::vector<std::byte> difference_;                    // of the last comparison
    std::vector<std::byte> compared_, compared_reference_; // its pictures
    std::size_t compared_frame_ = 0;                       // counted from 1
    double updated_cpu_ms_ = 0.0, updated_wall_ms_ = 0.0;  // of the game alone, in this frame
};

} // namespace alpenglow::sandbox
