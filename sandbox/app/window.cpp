#include "sandbox/app/window.hpp"

#define GLFW_INCLUDE_NONE
#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include <cstdint>

namespace alpenglow::sandbox {
namespace {

Error glfw_error(const char* what) {
    const char* detail = nullptr;
    glfwGetError(&detail);
    return {std::string(what) + (detail != nullptr ? std::string(": ") + detail : std::string()), "window",
            "a display (DISPLAY or WAYLAND_DISPLAY), or --headless"};
}

Window* self(GLFWwindow* window) {
    return static_cast<Window*>(glfwGetWindowUserPointer(window));
}

} // namespace

Result<std::unique_ptr<Window>> Window::open(int width, int height, const std::string& title) {
    if (glfwInit() != GLFW_TRUE) {
        return glfw_error("no display");
    }
    if (glfwVulkanSupported() != GLFW_TRUE) {
        const Error error = glfw_error("this display has no Vulkan surface");
        glfwTerminate();
        return error;
    }
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window == nullptr) {
        const Error error = glfw_error("the window cannot be opened");
        glfwTerminate();
        return error;
    }
    return std::unique_ptr<Window>(new Window(window));
}

Window::Window(GLFWwindow* window) : window_(window) {
    glfwSetWindowUserPointer(window_, this);
    glfwGetCursorPos(window_, &last_cursor_.x, &last_cursor_.y);
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
        if (action == GLFW_PRESS) {
            self(w)->pressed_.push_back(key);
        }
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double dy) { self(w)->wheel_ += static_cast<float>(dy); });
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

std::vector<const char*> Window::instance_extensions() const {
    std::uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    return {names, names + count};
}

Result<VkSurfaceKHR> Window::create_surface(VkInstance instance) const {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    if (glfwCreateWindowSurface(instance, window_, nullptr, &surface) != VK_SUCCESS) {
        return glfw_error("no Vulkan surface for the window");
    }
    return surface;
}

void Window::capture_mouse(bool capture) {
    if (capture != captured_) {
        captured_ = capture;
        glfwSetInputMode(window_, GLFW_CURSOR, capture ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
        glfwGetCursorPos(window_, &last_cursor_.x, &last_cursor_.y);
    }
}

Input Window::poll(bool ui_wants_mouse, bool ui_wants_keys) {
    glfwPollEvents();
    Input input;
    // The mouse looks around while a button is held over the scene.
    const bool button = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS ||
                        glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
    capture_mouse(button && (captured_ || !ui_wants_mouse));
    glm::dvec2 cursor{0.0};
    glfwGetCursorPos(window_, &cursor.x, &cursor.y);
    if (captured_) {
        input.look = glm::vec2(cursor - last_cursor_);
    }
    last_cursor_ = cursor;
    if (!ui_wants_mouse) {
        input.speed_steps = wheel_;
    }
    wheel_ = 0.0F;
    if (!ui_wants_keys) {
        const auto axis = [&](int positive, int negative) {
            return static_cast<float>(glfwGetKey(window_, positive) == GLFW_PRESS) -
                   static_cast<float>(glfwGetKey(window_, negative) == GLFW_PRESS);
        };
        input.move = {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_W, GLFW_KEY_S), axis(GLFW_KEY_E, GLFW_KEY_Q)};
        input.fast = glfwGetKey(window_, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS;
        input.pressed = std::move(pressed_);
    }
    pressed_.clear();
    return input;
}

bool Window::should_close() const {
    return glfwWindowShouldClose(window_) == GLFW_TRUE;
}
void Window::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

glm::ivec2 Window::framebuffer_size() const {
    glm::ivec2 size{0};
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(window_, title.c_str());
}

} // namespace alpenglow::sandbox
