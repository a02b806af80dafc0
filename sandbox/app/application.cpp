#include "sandbox/app/application.hpp"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <alpenglow/core/timing.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/instance.hpp>
#include <alpenglow/vulkan/swapchain.hpp>

#include "sandbox/app/game.hpp"
#include "sandbox/app/picture.hpp"
#include "sandbox/app/report.hpp"
#include "sandbox/app/session.hpp"
#include "sandbox/app/window.hpp"
#include "sandbox/render/renderer.hpp"
#include "sandbox/scene/scene.hpp"

namespace alpenglow::sandbox {
namespace {

void say(const std::string& text) {
    std::cerr << "alpenglow-sandbox: " << text << '\n';
}

Exit fail(const Error& error, Exit code) {
    say(error.message());
    return code;
}

// The scene that the options ask for.
Result<Scene> chosen_scene(const Options& options) {
    Result<Scene> scene = load_scene(options.scene);
    if (!scene) {
        return scene;
    }
    scene->utc_j2000_s = options.utc_j2000_s.value_or(scene->utc_j2000_s);
    scene->latitude_deg = options.latitude_deg.value_or(scene->latitude_deg);
    scene->longitude_deg = options.longitude_deg.value_or(scene->longitude_deg);
    scene->chart.show = options.chart.value_or(scene->chart.show);
    scene->chart.bands = options.chart_bands.value_or(scene->chart.bands);
    if (options.quality) {
        scene->quality = *options.quality;
    }
    return scene;
}

// The files that the options ask for, from what the session left.
Exit write_results(const Session& session, const Options& options, const std::string& picture) {
    if (!picture.empty()) {
        const auto pixels = session.renderer->read_pixels();
        if (!pixels) {
            return fail(pixels.error(), Exit::failed);
        }
        const VkExtent2D extent = session.renderer->extent();
        const Status written =
            write_png(picture, static_cast<int>(extent.width), static_cast<int>(extent.height), *pixels);
        if (!written) {
            return fail(written.error(), Exit::bad_input);
        }
        say("the picture is in " + picture);
        if (!session.difference().empty()) {
            const std::string difference = picture.substr(0, picture.rfind('.')) + "-difference.png";
            if (const Status differs = write_png(difference, static_cast<int>(extent.width),
                                                 static_cast<int>(extent.height), session.difference());
                !differs) {
                return fail(differs.error(), Exit::bad_input);
            }
            say("the difference, 16 times, is in " + difference);
        }
    }
    if (!options.report.empty()) {
        const Status written = write_file(options.report, to_json(session.report));
        if (!written) {
            return fail(written.error(), Exit::bad_input);
        }
    }
    return Exit::fine;
}

// What the validation layer said. Its messages make the run fail.
Exit report_validation(const vulkan::Instance& instance) {
    const auto messages = instance.messages().messages();
    for (const std::string& message : messages) {
        say("validation: " + message);
    }
    if (instance.validates()) {
        say("validation: " + std::to_string(messages.size()) + " messages");
    }
    return messages.empty() ? Exit::fine : Exit::failed;
}

// Owns the surface between instance and device.
struct Surface {
    VkInstance instance = VK_NULL_HANDLE;
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    Surface() = default;
    Surface(const Surface&) = delete;
    Surface& operator=(const Surface&) = delete;
    ~Surface() {
        if (surface != VK_NULL_HANDLE) {
            vkDestroySurfaceKHR(instance, surface, nullptr);
        }
    }
};

} // namespace

Exit run(const Options& options) {
    if (options.help) {
        std::cout << help_text();
        return Exit::fine;
    }
    if (options.list_scenes) {
        for (const std::string& name : builtin_scene_names()) {
            const auto scene = load_scene(name);
            std::cout << name << (scene ? "  " + scene->description : std::string()) << '\n';
        }
        return Exit::fine;
    }
    for (const auto& [option, path] : {std::pair{"--out", options.out}, std::pair{"--report", options.report}}) {
        if (!path.empty()) {
            if (const Status writable = check_writable(option, path); !writable) {
                return fail(writable.error(), Exit::bad_input);
            }
        }
    }
    const Result<Scene> scene = chosen_scene(options);
    if (!scene) {
        return fail(scene.error(), Exit::bad_input);
    }
    if (options.threads > 0) {
        setenv("ALPENGLOW_THREADS", std::to_string(options.threads).c_str(), 1);
    }

    // A window where there can be one.
    std::unique_ptr<Window> window;
    if (!options.headless) {
        Result<std::unique_ptr<Window>> opened = Window::open(options.width, options.height, "Alpenglow");
        if (opened) {
            window = std::move(opened).value();
        } else {
            say(opened.error().message() + "; rendering headless");
        }
    }

    vulkan::InstanceOptions instance_options{.validation = options.validate, .application = "alpenglow-sandbox"};
    const std::vector<const char*> extensions = window ? window->instance_extensions() : std::vector<const char*>{};
    instance_options.extensions = extensions;
    const Result<vulkan::Instance> instance = vulkan::Instance::create(instance_options);
    if (!instance) {
        return fail(instance.error(), Exit::no_device);
    }
    Exit code = Exit::fine;
    {
        Surface surface;
        if (window) {
            const Result<VkSurfaceKHR> created = window->create_surface(instance->get());
            if (!created) {
                return fail(created.error(), Exit::no_device);
            }
            surface.instance = instance->get();
            surface.surface = *created;
        }
        const Result<vulkan::Device> device =
            vulkan::Device::create(*instance, {.name = options.device, .surface = surface.surface});
        if (!device) {
            return fail(device.error(), Exit::no_device);
        }
        Result<std::unique_ptr<Session>> session =
            Session::create(*instance, *device, *scene, options, window.get(), surface.surface);
        if (!session) {
            // A device that takes the instance but not the frame: out of memory, or a size past its limits.
            return fail(session.error(), Exit::no_device);
        }
        const Status finished =
            window ? (*session)->play() : (*session)->render(options.frames > 0 ? options.frames : 1);
        if (!finished) {
            return fail(finished.error(), Exit::failed);
        }
        const std::string picture = options.out.empty() && !window ? "alpenglow-" + scene->name + ".png" : options.out;
        code = write_results(**session, options, picture);
    }
    const Exit validation = report_validation(*instance);
    return code != Exit::fine ? code : validation;
}

} // namespace alpenglow::sandbox
