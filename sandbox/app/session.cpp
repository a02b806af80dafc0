#include "sandbox/app/session.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <alpenglow/core/timing.hpp>

#include "sandbox/app/picture.hpp"
#include "sandbox/app/picture_difference.hpp"
#include "sandbox/scene/scene.hpp"
#include "sandbox/world/landscape_file.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double headless_step_s = 1.0 / 60.0;
constexpr int panel_refresh_frames = 15;
constexpr float look_rad_per_pixel = 0.003F;
constexpr float eye_clearance_m = 2.0F;

// The landscape that the build has generated: beside the program or where the build left it.
std::unique_ptr<World> landscape() {
    std::vector<std::filesystem::path> files;
    std::error_code failed;
    if (const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed); !failed) {
        files.push_back(program.parent_path() / built_landscape().filename());
    }
    if (files.empty() || files.front() != built_landscape()) {
        files.push_back(built_landscape());
    }
    OpenedWorld opened = open_world(files);
    if (opened.generated) {
        for (const Error& problem : opened.problems) {
            std::cerr << "alpenglow-sandbox: " << problem.message() << '\n';
        }
        std::cerr << "alpenglow-sandbox: generating the landscape\n";
    }
    return std::move(opened.world);
}

VkExtent2D extent_of(const glm::ivec2& size) {
    return {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y)};
}

} // namespace

Result<std::unique_ptr<Session>> Session::create(const vulkan::Instance& instance, const vulkan::Device& device,
                                                 const Scene& scene, const Options& options, Window* window,
                                                 VkSurfaceKHR surface) {
    std::unique_ptr<Session> session(new Session);
    Session& s = *session;
    s.device_ = &device;
    s.window_ = window;
    s.options_ = options;
    const glm::ivec2 size = window != nullptr ? window->framebuffer_size() : glm::ivec2(options.width, options.height);
    s.game = std::make_unique<Game>(scene, landscape());
    RendererOptions render_options{.extent = extent_of(size), .quality = scene.quality};
#ifdef ALPENGLOW_SHADER_DIRECTORY
    render_options.shader_directory = ALPENGLOW_SHADER_DIRECTORY;
#endif
    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(device, s.game->world().data, render_options);
    if (!renderer) {
        return renderer.error();
    }
    s.renderer = std::move(renderer).value();
    s.game->quality = s.renderer->quality();
    s.game->storage_bytes = device.info().limits.maxStorageBufferRange;
    s.game->capture_with([&s](const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels) {
        if (const Status captured = s.renderer->capture(frame, point_m, face, texels); !captured) {
            s.panel_.message = captured.error().message();
            std::fill(texels.begin(), texels.end(), glm::vec3(std::numeric_limits<float>::quiet_NaN())); // not a probe
        }
    });
    if (window != nullptr) {
        Result<vulkan::Swapchain> swapchain =
            vulkan::Swapchain::create(device, {.surface = surface, .extent = extent_of(size)});
        if (!swapchain) {
            return swapchain.error();
        }
        s.swapchain_ = std::move(swapchain).value();
    }
    if (window != nullptr || options.hud) {
        s.imgui_ = ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr; // the panel's places are not worth a file in the player's folder
        if (window != nullptr) {
            ImGui_ImplGlfw_InitForVulkan(window->handle(), true);
        }
        if (const Status enabled = s.renderer->enable_hud(instance); !enabled) {
            return enabled.error();
        }
    }
    s.tell_problems();
    s.panel_.device = device.info().name;
    s.panel_.scenes = builtin_scene_names();
    for (std::size_t i = 0; i < s.panel_.scenes.size(); ++i) {
        if (s.panel_.scenes[i] == scene.name) {
            s.panel_.scene = static_cast<int>(i);
        }
    }
    s.stopped_rate_ = scene.time_rate > 0.0 ? scene.time_rate : 1.0;
    s.report.scene = scene.name;
    s.report.device = device.info().name;
    s.report.quality = to_string(s.renderer->quality());
    s.report.width = size.x;
    s.report.height = size.y;
    return session;
}

Session::~Session() {
    renderer.reset(); // owns ImGui's Vulkan backend
    if (imgui_ != nullptr) {
        if (window_ != nullptr) {
            ImGui_ImplGlfw_Shutdown();
        }
        ImGui::DestroyContext(imgui_);
    }
}

// On standard error, and in the panel.
void Session::tell_problems() {
    for (const Error& problem : game->take_problems()) {
        panel_.message = problem.message();
        std::cerr << "alpenglow-sandbox: " << problem.message() << "; the scene goes on without it\n";
    }
}

// The panel's draw data for this frame; null where there is none.
ImDrawData* Session::draw_hud() {
    if (imgui_ == nullptr) {
        return nullptr;
    }
    if (--frames_until_refresh_ <= 0) {
        frames_until_refresh_ = panel_refresh_frames;
        panel_.reports.assign(game->reports().begin(), game->reports().end());
        panel_.utc_j2000_s = game->clock().utc_j2000_s;
        panel_.texts.clear();
    }
    if (window_ != nullptr) {
        ImGui_ImplGlfw_NewFrame();
    } else {
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {static_cast<float>(options_.width), static_cast<float>(options_.height)};
        io.DeltaTime = static_cast<float>(headless_step_s);
    }
    ImGui::NewFrame();
    draw_panel(*game, panel_);
    ImGui::Render();
    return ImGui::GetDrawData();
}

Status Session::draw(double dt_s) {
    const VkExtent2D extent = renderer->extent();
    if (window_ == nullptr) {
        game->wait();
    }
    const double cpu = process_cpu_seconds();
    const double wall = wall_seconds();
    game->update(dt_s, static_cast<int>(extent.width), static_cast<int>(extent.height));
    updated_cpu_ms_ = (process_cpu_seconds() - cpu) * 1e3;
    updated_wall_ms_ = (wall_seconds() - wall) * 1e3;
    const double draw_cpu = thread_cpu_seconds();
    const Result<DrawStats> stats = renderer->draw(game->frame(), swapchain_ ? &*swapchain_ : nullptr, draw_hud());
    if (!stats) {
        return stats.error();
    }
    FrameReport frame;
    frame.systems.assign(game->reports().begin(), game->reports().end());
    // Drawing as a system: `updated` counts buffers uploaded anew, objects out of view are skipped.
    frame.systems.push_back({.system = "draw",
                             .considered = stats->objects_considered,
                             .updated = stats->uploads,
                             .skipped = stats->objects_considered - stats->objects_drawn,
                             .cpu_ms = (thread_cpu_seconds() - draw_cpu) * 1e3});
    if (window_ == nullptr) {
        // A headless frame's cost is the whole of it: wait for the device.
        if (const Status done = renderer->finish(); !done) {
            return done;
        }
    }
    frame.cpu_ms = (process_cpu_seconds() - cpu) * 1e3;
    frame.wall_ms = (wall_seconds() - wall) * 1e3;
    if (frames_until_refresh_ <= 1) {
        panel_.frame_cpu_ms = frame.cpu_ms;
        panel_.frame_wall_ms = frame.wall_ms;
    }
    if (window_ == nullptr || options_.frames > 0 || !options_.report.empty()) {
        report.frames.push_back(std::move(frame));
    }
    if (options_.compare > 0 && window_ == nullptr &&
        report.frames.size() % static_cast<std::size_t>(options_.compare) == 0) {
        if (const Status compared = compare(); !compared) {
            return compared;
        }
    }
    if (swapchain_ && !stats->presented) {
        return fit_window();
    }
    return Ok{};
}

// Draws the frame once more without the parts' shortcuts, and reports how far the two pictures are apart: `compare`
// (`error_bound`: PSNR in dB), `compare_steps` (temporal_difference() against the frame before, where that was compared
// too), and what the frame costs when drawn like that.
Status Session::compare() {
    const auto shown = renderer->read_pixels();
    if (!shown) {
        return shown.error();
    }
    bool differs = false;
    FrameReport& frame = report.frames.back();
    double saved_cpu_ms = 0.0; // what the shortcuts cost
    for (const SystemReport& system : frame.systems) {
        const std::string_view name = system.system;
        if (name == "captures" || name == "impostors") {
            saved_cpu_ms += system.cpu_ms;
        }
    }
    const double cpu = process_cpu_seconds();
    const double wall = wall_seconds();
    for (const std::unique_ptr<Part>& part : game->parts()) {
        differs = part->show_reference(true) || differs;
    }
    if (!differs) {
        return Ok{};
    }
    const Result<DrawStats> drawn = renderer->draw(game->frame(), nullptr, nullptr);
    if (!drawn) {
        return drawn.error();
    }
    if (const Status done = renderer->finish(); !done) {
        return done;
    }
    frame.direct_cpu_ms = (process_cpu_seconds() - cpu) * 1e3 + updated_cpu_ms_ - saved_cpu_ms;
    frame.direct_wall_ms = (wall_seconds() - wall) * 1e3 + std::max(0.0, updated_wall_ms_ - saved_cpu_ms);
    auto reference = renderer->read_pixels();
    if (!reference) {
        return reference.error();
    }
    PictureDifference difference = picture_difference(*shown, *reference);
    for (const std::unique_ptr<Part>& part : game->parts()) {
        if (part->show_reference(false)) {
            part->compared(difference.psnr_db);
        }
    }
    frame.systems.push_back({.system = "compare", .error_bound = difference.psnr_db});
    if (compared_frame_ + 1 == report.frames.size() && compared_.size() == shown->size()) {
        frame.systems.push_back(
            {.system = "compare_steps",
             .error_bound = temporal_difference(compared_, *shown, compared_reference_, *reference)});
    }
    compared_frame_ = report.frames.size();
    compared_ = *shown;
    compared_reference_ = std::move(reference).value();
    difference_ = std::move(difference.amplified);
    return Ok{};
}

Status Session::render(int frames) {
    for (int i = 0; i < frames; ++i) {
        if (const Status drawn = draw(i == 0 ? 0.0 : headless_step_s); !drawn) {
            return drawn;
        }
    }
    return Ok{};
}

// After the window has changed: new targets of its size.
Status Session::fit_window() {
    const glm::ivec2 size = window_->framebuffer_size();
    if (size.x == 0 || size.y == 0) {
        return Ok{}; // minimised
    }
    if (const Status resized = renderer->resize(extent_of(size)); !resized) {
        return resized;
    }
    return swapchain_->recreate(extent_of(size));
}

Status Session::act(const Input& input, double dt_s) {
    Camera& camera = game->camera;
    camera.turn(input.look.x * look_rad_per_pixel, -input.look.y * look_rad_per_pixel);
    speed_m_s_ = std::clamp(speed_m_s_ * std::exp2(static_cast<double>(input.speed_steps) * 0.25), 1.0, 5000.0);
    const double speed = speed_m_s_ * (input.fast ? 10.0 : 1.0);
    camera.move(glm::vec3(input.move.x, input.move.z, input.move.y) * static_cast<float>(speed * dt_s));
    camera.stay_above(game->world().terrain.height_m(glm::vec2(camera.position_m)), eye_clearance_m);

    WorldClock& clock = game->clock();
    for (const int key : input.pressed) {
        switch (key) {
        case GLFW_KEY_ESCAPE:
            window_->close();
            break;
        case GLFW_KEY_H:
            panel_.visible = !panel_.visible;
            break;
        case GLFW_KEY_F1:
            panel_.help = !panel_.help;
            break;
        case GLFW_KEY_F12:
            panel_.screenshot = true;
            break;
        case GLFW_KEY_SPACE:
            if (clock.rate != 0.0) {
                stopped_rate_ = std::exchange(clock.rate, 0.0);
            } else {
                clock.rate = stopped_rate_;
            }
            break;
        case GLFW_KEY_COMMA:
            clock.rate = clock.rate <= 1.0 ? 0.0 : clock.rate / 10.0;
            break;
        case GLFW_KEY_PERIOD:
            clock.rate = clock.rate < 1.0 ? 1.0 : std::min(clock.rate * 10.0, 10000.0);
            break;
        case GLFW_KEY_LEFT_BRACKET:
            clock.utc_j2000_s -= 3600.0;
            break;
        case GLFW_KEY_RIGHT_BRACKET:
            clock.utc_j2000_s += 3600.0;
            break;
        case GLFW_KEY_PAGE_UP:
        case GLFW_KEY_PAGE_DOWN: {
            const int count = static_cast<int>(panel_.scenes.size());
            panel_.scene = (panel_.scene + (key == GLFW_KEY_PAGE_UP ? 1 : count - 1)) % count;
            panel_.scene_chosen = true;
            break;
        }
        default:
            for (const std::unique_ptr<Part>& part : game->parts()) {
                if (part->press(key)) { // GLFW's letters and digits are ASCII capitals
                    break;
                }
            }
        }
    }
    if (std::exchange(panel_.scene_chosen, false)) {
        const Result<Scene> scene = load_scene(panel_.scenes[static_cast<std::size_t>(panel_.scene)]);
        if (!scene) {
            return scene.error();
        }
        game->enter(*scene);
        tell_problems();
    }
    if (std::exchange(panel_.screenshot, false)) {
        const auto pixels = renderer->read_pixels();
        if (!pixels) {
            return pixels.error();
        }
        const VkExtent2D extent = renderer->extent();
        const std::string path = "alpenglow-" + std::to_string(++screenshots_) + ".png";
        const Status written =
            write_png(path, static_cast<int>(extent.width), static_cast<int>(extent.height), *pixels);
        panel_.message = written ? "screenshot: " + path : written.error().message();
    }
    return Ok{};
}

Status Session::play() {
    double last = wall_seconds();
    double looked_for_shaders = last;
    int drawn_frames = 0;
    while (!window_->should_close() && (options_.frames == 0 || drawn_frames < options_.frames)) {
        const double now = wall_seconds();
        const double dt_s = std::min(now - last, 0.25); // a stall does not throw the camera across the valley
        last = now;
        if (const Status acted =
                act(window_->poll(ImGui::GetIO().WantCaptureMouse, ImGui::GetIO().WantCaptureKeyboard), dt_s);
            !acted) {
            return acted;
        }
        const glm::ivec2 size = window_->framebuffer_size();
        if (size.x == 0 || size.y == 0) {
            continue;
        }
        if (extent_of(size).width != renderer->extent().width || extent_of(size).height != renderer->extent().height) {
            if (const Status fitted = fit_window(); !fitted) {
                return fitted;
            }
        }
        if (now - looked_for_shaders > 0.5) {
            looked_for_shaders = now;
            for (const std::string& message : renderer->reload_shaders()) {
                panel_.message = message;
                std::cerr << "alpenglow-sandbox: " << message << '\n';
            }
        }
        if (const Status drawn = draw(dt_s); !drawn) {
            return drawn;
        }
        ++drawn_frames;
    }
    return Ok{};
}

} // namespace alpenglow::sandbox
