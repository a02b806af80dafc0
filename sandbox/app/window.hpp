// The window and its input (GLFW). Headless runs never construct one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vulkan/vulkan_core.h>

#include <alpenglow/core/result.hpp>

struct GLFWwindow;

namespace alpenglow::sandbox {

// What the player did since the last poll.
struct Input {
    glm::vec3 move{0.0F};     // right, forward, up; each -1, 0 or 1
    glm::vec2 look{0.0F};     // mouse motion in pixels while the mouse is captured
    float speed_steps = 0.0F; // mouse wheel: powers of the flying speed
    bool fast = false;        // Shift held
    std::vector<int> pressed; // GLFW key codes pressed since the last poll
};

class Window {
public:
    // Opens a window that can be resized. The error says when there is no display.
    static Result<std::unique_ptr<Window>> open(int width, int height, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    [[nodiscard]] std::vector<const char*> instance_extensions() const;
    [[nodiscard]] Result<VkSurfaceKHR> create_surface(VkInstance instance) const;

    // Handles pending events. `ui_wants_mouse` and `ui_wants_keys` keep what the panel uses from the game.
    Input poll(bool ui_wants_mouse, bool ui_wants_keys);
    [[nodiscard]] bool should_close() const;
    void close();
    [[nodiscard]] glm::ivec2 framebuffer_size() const; // 0 x 0 while minimised
    void set_title(const std::string& title);
    [[nodiscard]] GLFWwindow* handle() const { return window_; }

private:
    explicit Window(GLFWwindow* window);
    void capture_mouse(bool capture);

    GLFWwindow* window_;
    bool captured_ = false;
    glm::dvec2 last_cursor_{0.0};
    std::vector<int> pressed_;
    float wheel_ = 0.0F;
};

} // namespace alpenglow::sandbox
